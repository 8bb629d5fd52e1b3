"""HDF5, MAT, NPZ and Parquet: the same numbers from each, and what cannot be numbers is refused."""

import gzip
import re

import h5py
import numpy as np
import pytest

import hydrofdi
from hydrofdi.api.sources import Described, open_records
from hydrofdi.errors import ConfigError, DataError, HydrofdiError, StoreError
from hydrofdi.records import Channel
from hydrofdi.records.columns import NAMES
from hydrofdi.records.source import measured_source, plain_source
from hydrofdi.store.experiment_file import read_experiment
from tests.conftest import REPOSITORY
from tests.records.measuring import (
    BOTH,
    P1,
    P2,
    SUPPLY,
    USUAL,
    WRITERS,
    csv_of,
    described,
    one,
    plain,
    read,
    yaml_of,
)

BAR = np.array([100.0, 101.5, 99.25, 102.125, 7.0])
TABLE = np.column_stack([BAR, BAR + 1])


def description(name, column="P1", *more):
    return yaml_of(f'P1: {{column: "{column}", unit: bar}}', *more, files=name)


@pytest.mark.parametrize("suffix", WRITERS)
def test_every_format_gives_the_same_numbers_packed_or_not(tmp_path, suffix):
    file = tmp_path / f"run.{suffix}"
    WRITERS[suffix](file, {"P1": BAR, "P2": BAR + 1})
    (tmp_path / f"run.{suffix}.gz").write_bytes(gzip.compress(file.read_bytes()))
    np.testing.assert_array_equal(one(tmp_path, description(f"run.{suffix}*"))[P1], [BAR * 1e5] * 2)


@pytest.mark.parametrize(("suffix", "arrays", "column"), [
    ("h5", {"data": TABLE}, "data[2]"), ("mat", {"data": TABLE.T}, "data[2]"),
    ("npz", {"data": TABLE.T}, "data[2]"), *(
        (suffix, {"rig/P1": BAR + 1, "rig/x": BAR}, "rig/P1") for suffix in ("h5", "mat")
    ),
])  # fmt: skip
def test_a_column_of_a_table_is_found_whichever_axis_is_time_or_in_a_group(tmp_path, suffix, arrays, column):
    WRITERS[suffix](tmp_path / f"run.{suffix}", arrays)
    np.testing.assert_array_equal(one(tmp_path, description(f"run.{suffix}", column))[P1], [(BAR + 1) * 1e5])


def as_mat_7_3(file):
    """An HDF5 file with a user block becomes a MAT file of version 7.3."""
    with open(file, "r+b") as target:
        target.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")


def test_a_mat_file_of_version_7_3_is_hdf5(tmp_path):
    with h5py.File(tmp_path / "run.mat", "w", userblock_size=512) as target:
        target["P1"] = BAR[:, None].T
    as_mat_7_3(tmp_path / "run.mat")
    np.testing.assert_array_equal(one(tmp_path, description("run.mat"))[P1], [BAR * 1e5])


def test_units_of_attributes_are_taken_and_compared_and_names_may_be_any_bytes(tmp_path):
    with h5py.File(tmp_path / "run.h5", "w") as target:
        target["P1"] = target[b"P\xff"] = BAR
        target["P1"].attrs["units"] = "MPa"
    with pytest.raises(DataError, match="MPa"):
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
    WRITERS["parquet"](tmp_path / "run.parquet", {"P1": [1, None, 3]})
    (remark,) = one(tmp_path, description("run.parquet")).remarks[0]
    assert (remark.kind, remark.is_unusable) == ("missing", True)


@pytest.mark.parametrize(("suffix", "values", "named"), [
    *((suffix, {"P1": values}, "P1: contains") for suffix, values in (
        ("h5", BAR + 1j), ("npz", np.array([1, 2**53 + 1, 3])), ("h5", [b"a", b"b"]), ("mat", ["a", "b"]),
    )),
    ("npz", {}, r"run\.npz: has no column 'P1'"), ("npz", {"P1": np.array([print], dtype=object)}, "damaged"),
    ("npz", {"P1": BAR, "P2": BAR[:3]}, "wrong_length"),
])  # fmt: skip
def test_what_is_no_column_of_real_numbers_is_refused_and_objects_are_never_loaded(
    tmp_path, suffix, values, named
):
    WRITERS[suffix](tmp_path / f"run.{suffix}", values)
    stated = (BOTH if "P2" in values else USUAL).replace("*.csv", f"run.{suffix}")
    if named in ("damaged", "wrong_length"):
        assert one(tmp_path, stated).rejected[0].remark.kind == named
    else:
        with pytest.raises(DataError, match=named):
            one(tmp_path, stated)


def test_whole_numbers_do_not_overflow(tmp_path):
    np.savez(tmp_path / "run.npz", P1=np.array([-128, 127, 100], dtype=np.int8))
    turned = description("run.npz").replace("unit: bar", "unit: bar, sign: -1")
    np.testing.assert_array_equal(one(tmp_path, turned)[P1], [[128e5, -127e5, -100e5]])


@pytest.mark.parametrize("place", ["external storage", "a linked file", "virtual sources"])
@pytest.mark.parametrize("suffix", ["h5", "mat"])
def test_values_in_other_files_are_never_read(tmp_path, place, suffix):
    run, other = tmp_path / f"run.{suffix}", str(tmp_path / "other.h5")
    WRITERS["h5"](tmp_path / "other.h5", {"P1": BAR})
    with h5py.File(run, "w", userblock_size=512 * (suffix == "mat")) as file:
        file["own"] = BAR
        if place == "external storage":
            file.create_dataset("P1", (3,), "f8", external=[(other, 2048, 24)])
        elif place == "a linked file":
            file["P1"] = h5py.ExternalLink(other, "P1")
        else:
            layout = h5py.VirtualLayout((5,), "f8")
            layout[:] = h5py.VirtualSource(other, "P1", (5,))
            file.create_virtual_dataset("P1", layout)
    if suffix == "mat":
        as_mat_7_3(run)
    for column in ("P1", "own"):
        (rejected,) = one(tmp_path, description(run.name, column)).rejected
        assert (rejected.remark.kind, "\n" in rejected.remark.message) == ("damaged", False)
    with pytest.raises(StoreError):
        read_experiment(run)


TIME = np.arange(400) / 200.0
NOISE = np.random.default_rng(8).normal(0.0, 1.0, (2, TIME.size))


def _text(row, p1="P1 [bar]", factor=1.0, p2="P2 [bar]"):
    return csv_of(("time [s]", TIME), (p1, (80 + NOISE[row]) * factor), (p2, 60 + NOISE[row]))


@pytest.fixture
def folder(tmp_path):
    (place := tmp_path / "rig").mkdir()
    (place / "run 2.csv").write_text(_text(0))
    (place / "run 10.csv").write_text(_text(1, "P1 [MPa]", factor=0.1))
    (place / "readme.txt").write_text("Recorded on a Monday.\n")
    (place / ".hidden.csv").write_text("nothing")
    return place


def test_a_folder_of_such_files_is_measured_as_its_files_are(folder):
    """The first of them that can be read states the columns."""
    (folder / "run 1.csv").write_text("")
    together = hydrofdi.measure(folder, "dwt")
    one_by_one = hydrofdi.measure([folder / "run 2.csv", folder / "run 10.csv"], "dwt")
    assert together["record_id"].tolist() == ["run 2.csv", "run 10.csv", "run 1.csv"]
    np.testing.assert_array_equal(together["dwt.d3"][:2], one_by_one["dwt.d3"])


def test_a_description_of_files_alone_takes_channels_units_and_time_from_headers(folder):
    (source,) = open_records(described(folder, 'files: "*.csv"\ngroup: "{file}"\ndrive_period: 1 s\n'))
    batch = read(source)
    assert set(batch.channels) == {P1, P2}
    assert (batch.sampling_frequency, batch.drive_period) == (200.0, 1.0)
    np.testing.assert_allclose(batch[P1], (80 + NOISE) * 1e5)
    with pytest.raises(ConfigError, match=r"measured.yaml:2: segment: needs the channel piston_position"):
        open_records(described(folder, 'files: "*.csv"\nsegment: {part: motion}\n'))
    with pytest.raises(DataError, match=r"measured.yaml"):  # instead of the folder
        open_records(folder)


def test_columns_that_nobody_recognises_are_named_and_a_file_with_other_columns_is_refused(folder):
    (folder / "run 2.csv").write_text(_text(0, p2="torque [Nm]"))
    (batch,) = open_records(folder)[0].batches()
    assert "torque [Nm]" in batch.remarks[0][0].message
    (folder / "run 10.csv").write_text(_text(1, "pressure_sensor [bar]"))
    with pytest.raises(DataError, match=r"run 10.csv: has no column 'P1'"):
        list(open_records(folder)[0].batches())
    (folder / "run 2.csv").write_text(csv_of(("pressure_sensor [bar]", 1 + NOISE[0]), ("P1 [bar]", NOISE[0])))
    with pytest.raises(DataError, match=r"run 2.csv: no sampling frequency"):
        open_records(folder)
    (folder / "run 10.csv").unlink()
    assert read(open_records(folder, said=Described(50.0))[0]).sampling_frequency == 50.0


@pytest.mark.parametrize(("channels", "message"), [
    (["P1: {column: a, unit: bar}", "x: {column: b, unit: bar}"], "5: channels.x.unit: "),
    (["P1: a", "chamber_1_pressure: b"], "5: channels.chamber_1_pressure: is given twice"),
    (["P1: a", "P2: a"], "5: channels.P2: has the column of chamber_1_pressure"),
    (["P9: a"], "4: channels.P9: "),
])  # fmt: skip
def test_a_mistake_is_found_under_the_name_that_is_written(tmp_path, channels, message):
    lines = "".join(f"  {channel}\n" for channel in channels)
    text = f"files: rig.csv\nsampling_frequency: 1 kHz\nchannels:\n{lines}"
    with pytest.raises(HydrofdiError, match=rf"measured\.yaml:{message}"):
        hydrofdi.inspect(described(tmp_path, text, rig_csv="a,b\n50,0\n51,1\n"))


def test_the_schema_of_descriptions_takes_what_is_read():
    names = {name for channel in Channel for name in (channel.value, channel.symbol)}
    assert {*hydrofdi.schema("measured")["$defs"]["Channel"]["enum"]} == names


def test_a_huge_first_line_is_refused_in_a_short_sentence(tmp_path):
    with pytest.raises(DataError) as refused:
        plain(tmp_path, f"{','.join(['a' * 2000] * 500)}\n1,2,3\n")
    assert len(str(refused.value)) < 3000


PAGE = (REPOSITORY / "docs" / "measured.md").read_text(encoding="utf-8")


def test_the_example_of_the_page_reads_a_file_as_it_says(tmp_path):
    example, *_ = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    time = np.arange(9000)
    columns = {
        "t [ms]": time, "P1 [bar]": 100 + time % 7, "P2": 90 + time % 5, "I_s [mA]": 4 + time % 2,
        "x": -0.05 * (time % 4000), "u": np.where(time // 1000 % 4 < 2, 2, -2),
    }  # fmt: skip
    text = csv_of(*columns.items(), sign=";").replace(".", ",")
    (folder := tmp_path / "runs" / "unit 7").mkdir(parents=True)
    (folder / "sealed 3.csv.gz").write_bytes(gzip.compress(text.encode()))
    batch = next(measured_source(described(tmp_path, example)).batches(labels=True))
    assert batch.record_ids[0] == "runs/unit 7/sealed 3.csv.gz#1"
    assert (batch.groups[0].split(",")[0], batch.labels[0], batch.n_time) == ("7", "sealed", 2000)
    assert 100e5 <= batch[P1].min() <= batch[P1].max() <= 106e5
    np.testing.assert_allclose(np.unique(batch[SUPPLY]), [0.0, 15.625e5], atol=1e-6)


def test_the_page_lists_the_names_that_plain_files_are_read_by():
    for channel, names in NAMES.items():
        assert f"| `{channel}` | {names} |" in PAGE


DATE = 1_764_187_200
NANOSECONDS = DATE * 10**9 + 2_000_000 * np.arange(60)
TEXTS = [str(np.datetime64(each, "ns")).encode() for each in NANOSECONDS.tolist()]
DATES = NANOSECONDS.astype("datetime64[ns]")


@pytest.mark.parametrize(("times", "attributes", "date"), [
    (NANOSECONDS, {"units": "ns"}, DATE), (TEXTS, {}, DATE), (DATES, None, DATE),
    (2.0 * np.arange(60), {"units": "milliseconds since 2026-11-02 10:00"}, 1_793_613_600.0),
    (np.arange(60) * np.timedelta64(2, "ms"), None, np.nan),
], ids=["integers", "texts", "archive", "NetCDF", "durations"])  # fmt: skip
def test_a_clock_of_a_dataset_or_an_archive_gives_rate_and_date(tmp_path, times, attributes, date):
    file, pressure = tmp_path / "run.npz", 80.0 + np.sin(0.3 * np.arange(60))
    if attributes is None:
        np.savez(file, **{"time": times, "P1 [bar]": pressure})
    else:
        with h5py.File(file := tmp_path / "run.h5", "w") as target:
            target["time"], target["P1"] = times, pressure
            target["time"].attrs.update(attributes)
            target["matrix"] = np.ones((60, 3))
            target["P1"].attrs["units"] = "bar"
    batch = read(plain_source(file))
    assert batch.sampling_frequency == pytest.approx(500.0)
    assert batch.dates == (pytest.approx(date, nan_ok=True),)
