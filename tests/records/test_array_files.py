"""HDF5, MAT, NPZ and Parquet: the same numbers from each, and what cannot be numbers is refused."""

import gzip
import sys

import h5py
import numpy as np
import pytest
import scipy.io

from hydrofdi.errors import DataError, StoreError
from hydrofdi.records.measured.source import measured_source, plain_source
from hydrofdi.store.reading import read_experiment
from tests.records.measuring import P1, P2, described, one

BAR = np.array([100.0, 101.5, 99.25, 102.125, 7.0])
TABLE = np.column_stack([BAR, BAR + 1])


def write_hdf5(file, arrays):
    with h5py.File(file, "w") as target:
        for name, values in arrays.items():
            target[name] = values


def write_mat(file, arrays):
    nested = {}
    for name, values in arrays.items():
        *groups, last = name.split("/")
        inner = nested
        for group in groups:
            inner = inner.setdefault(group, {})
        inner[last] = values
    scipy.io.savemat(file, nested)


def write_npz(file, arrays):
    np.savez(file, **arrays)


def write_parquet(file, arrays):
    parquet, pyarrow = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow")
    parquet.write_table(pyarrow.table(arrays), file)


WRITERS = {"h5": write_hdf5, "mat": write_mat, "npz": write_npz, "parquet": write_parquet}


def description(name, column="P1", more=""):
    return f"""\
files: {name}
sampling_frequency: 1 kHz
channels: {{chamber_1_pressure: {{column: "{column}", unit: bar}}}}
{more}"""


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("packed", [False, True])
def test_every_format_gives_the_same_numbers(tmp_path, suffix, packed):
    file = tmp_path / f"run.{suffix}"
    WRITERS[suffix](file, {"P1": BAR, "P2": BAR + 1})
    if packed:
        file = file.rename(tmp_path / "plain")
        (tmp_path / f"run.{suffix}.gz").write_bytes(gzip.compress(file.read_bytes()))
    batch = one(tmp_path, description(f"run.{suffix}*"))
    np.testing.assert_array_equal(batch[P1], [BAR * 1e5])


@pytest.mark.parametrize("suffix", ["h5", "mat", "npz"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_column_of_a_table_is_found_whichever_axis_is_time(tmp_path, suffix, turned):
    WRITERS[suffix](tmp_path / f"run.{suffix}", {"data": TABLE.T if turned else TABLE})
    batch = one(tmp_path, description(f"run.{suffix}", "data[2]"))
    np.testing.assert_array_equal(batch[P1], [(BAR + 1) * 1e5])


@pytest.mark.parametrize("suffix", ["h5", "mat"])
def test_a_dataset_within_groups_is_found_by_its_path(tmp_path, suffix):
    WRITERS[suffix](tmp_path / f"run.{suffix}", {"rig/pressures/P1": BAR, "rig/x": BAR})
    batch = one(tmp_path, description(f"run.{suffix}", "rig/pressures/P1"))
    np.testing.assert_array_equal(batch[P1], [BAR * 1e5])
    with pytest.raises(DataError, match="has no column 'rig/pressures/P2'; it has rig/pressures/P1"):
        one(tmp_path, description(f"run.{suffix}", "rig/pressures/P2"))


def test_a_mat_file_of_version_7_3_is_hdf5(tmp_path):
    with h5py.File(tmp_path / "run.mat", "w", userblock_size=512) as target:
        target["P1"] = BAR[:, None].T
    with (tmp_path / "run.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file")
    np.testing.assert_array_equal(one(tmp_path, description("run.mat"))[P1], [BAR * 1e5])


def test_units_of_hdf5_attributes_are_taken_and_compared(tmp_path):
    with h5py.File(tmp_path / "run.h5", "w") as target:
        target["P1"] = BAR
        target["P1"].attrs["units"] = "MPa"
    with pytest.raises(DataError, match="the file says MPa, the description says bar"):
        one(tmp_path, description("run.h5"))
    batch = one(tmp_path, "files: run.h5\nsampling_frequency: 1 kHz\nchannels: {chamber_1_pressure: P1}\n")
    np.testing.assert_array_equal(batch[P1], [BAR * 1e6])


def test_numbers_that_netcdf_packs_are_unpacked(tmp_path):
    with h5py.File(tmp_path / "run.nc", "w") as target:
        target["P1"] = np.array([100, 200, -1, 300], dtype=np.int16)
        target["P1"].attrs.update({"scale_factor": 0.5, "add_offset": np.array([10.0]), "_FillValue": -1})
    batch = one(tmp_path, description("run.nc"))
    np.testing.assert_array_equal(batch[P1], [[60e5, 110e5, np.nan, 160e5]])
    assert batch.remarks[0][0].kind == "missing"


@pytest.mark.parametrize("suffix", ["h5", "mat", "npz"])
@pytest.mark.parametrize(("values", "sentence"), [
    (BAR + 1j, "P1: contains complex numbers"),
    (np.array([1, 2**53 + 1, 3]), r"P1: contains integers beyond 2\^53"),
    (np.array([b"a", b"b", b"c"]), "P1: contains .*, not numbers"),
])  # fmt: skip
def test_what_is_no_real_number_is_refused(tmp_path, suffix, values, sentence):
    values = np.array(["a", "b"]) if suffix == "mat" and values.dtype.kind == "S" else values
    WRITERS[suffix](tmp_path / f"run.{suffix}", {"P1": values})
    with pytest.raises(DataError, match=sentence):
        one(tmp_path, description(f"run.{suffix}"))


def test_whole_numbers_do_not_overflow(tmp_path):
    counts = np.array([-128, 127, 100, -100], dtype=np.int8)
    np.savez(tmp_path / "run.npz", P1=counts)
    batch = one(tmp_path, description("run.npz"))
    np.testing.assert_array_equal(batch[P1], [[-128e5, 127e5, 100e5, -100e5]])
    turned = description("run.npz").replace("unit: bar", "unit: bar, sign: -1")
    np.testing.assert_array_equal(one(tmp_path, turned)[P1], [[128e5, -127e5, -100e5, 100e5]])


def test_missing_integers_of_parquet_are_missing(tmp_path):
    write_parquet(tmp_path / "run.parquet", {"P1": [1, None, 3]})
    (remark,) = one(tmp_path, description("run.parquet")).remarks[0]
    assert (remark.kind, remark.is_unusable) == ("missing", True)
    assert "1 of 3" in remark.message


def test_parquet_without_its_extra_says_what_to_install(tmp_path, monkeypatch):
    (tmp_path / "run.parquet").write_bytes(b"PAR1")
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(DataError, match="needs the extra 'parquet'"):
        one(tmp_path, description("run.parquet"))


def test_pickled_objects_are_never_loaded(tmp_path):
    np.savez(tmp_path / "run.npz", P1=np.array([print], dtype=object))
    assert one(tmp_path, description("run.npz")).rejected[0].remark.kind == "damaged"


def in_external_storage(file, elsewhere):
    file.create_dataset("P1", (3,), "f8", external=[(str(elsewhere), 2048, 24)])


def in_a_linked_file(file, elsewhere):
    file["P1"] = h5py.ExternalLink(str(elsewhere), "P1")


def in_virtual_sources(file, elsewhere):
    layout = h5py.VirtualLayout((5,), "f8")
    layout[:] = h5py.VirtualSource(str(elsewhere), "P1", (5,))
    file.create_virtual_dataset("P1", layout)


@pytest.mark.parametrize("place", [in_external_storage, in_a_linked_file, in_virtual_sources])
@pytest.mark.parametrize("suffix", ["h5", "mat"])
def test_values_in_other_files_are_never_read(tmp_path, place, suffix):
    write_hdf5(tmp_path / "other.h5", {"P1": BAR})
    with h5py.File(tmp_path / f"run.{suffix}", "w", userblock_size=512 * (suffix == "mat")) as file:
        file["own"] = BAR
        place(file, tmp_path / "other.h5")
    if suffix == "mat":
        with open(tmp_path / "run.mat", "r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")
    for column in ("P1", "own"):
        (rejected,) = one(tmp_path, description(f"run.{suffix}", column)).rejected
        assert (rejected.remark.kind, "\n" in rejected.remark.message) == ("damaged", False)
    with pytest.raises(StoreError):
        read_experiment(tmp_path / f"run.{suffix}")


def test_columns_of_different_lengths_make_no_record(tmp_path):
    np.savez(tmp_path / "run.npz", P1=BAR, P2=BAR[:3])
    file = described(tmp_path, """\
files: run.npz
sampling_frequency: 1 kHz
channels:
  chamber_1_pressure: {column: P1, unit: bar}
  chamber_2_pressure: {column: P2, unit: bar}
""")  # fmt: skip
    (batch,) = measured_source(file).batches()
    assert batch.n_record == 0
    assert batch.rejected[0].remark.kind == "wrong_length"
    assert f"{P1} 5, {P2} 3" in batch.rejected[0].remark.message


@pytest.mark.parametrize("suffix", ["h5", "mat", "npz", "parquet", "csv.gz"])
def test_a_file_that_is_cut_off_is_rejected_with_the_reason(tmp_path, suffix):
    file = tmp_path / f"run.{suffix}"
    if suffix == "csv.gz":
        file.write_bytes(gzip.compress(b"P1\n" + b"1\n2\n" * 500))
    else:
        WRITERS[suffix](file, {"P1": np.arange(1000.0)})
    whole = file.read_bytes()
    for length in (1, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:length])
        batch = one(tmp_path, description(f"run.{suffix}"))
        assert [rejected.remark.kind for rejected in batch.rejected] == ["damaged"], length


def test_names_of_datasets_that_are_no_utf_8_do_no_harm(tmp_path):
    with h5py.File(tmp_path / "run.h5", "w") as target:
        target["P1"] = BAR
        target[b"P\xff"] = BAR
    np.testing.assert_array_equal(one(tmp_path, description("run.h5"))[P1], [BAR * 1e5])


@pytest.mark.parametrize("suffix", ["h5", "mat", "npz"])
def test_a_file_without_columns_is_named(tmp_path, suffix):
    WRITERS[suffix](tmp_path / f"run.{suffix}", {})
    with pytest.raises(DataError, match="contains no columns"):
        plain_source(tmp_path / f"run.{suffix}", 1e3)
    with pytest.raises(DataError, match="has no column 'P1'; it has none"):
        one(tmp_path, description(f"run.{suffix}"))
