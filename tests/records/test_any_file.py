"""Whatever a file holds: its numbers, or a sentence. Never a traceback, never another number."""

import contextlib
import gzip
import io
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from hydrofdi.errors import HydrofdiError
from hydrofdi.records import Channel
from hydrofdi.records import files as opening
from hydrofdi.records.source import measured_source, plain_source
from hydrofdi.units import parse_unit
from tests.records.measuring import WRITERS

FINITE = st.floats(allow_nan=False, allow_infinity=False, width=64).filter(lambda x: abs(x) < 1e290)
UNITS = {"Pa": ["Pa", "MPa", "bar", "psi"], "m": ["m", "mm", "in"], "V": ["V", "mV"]}
USUAL = "sampling_frequency: 1 kHz\nchannels: {chamber_1_pressure: {column: P1, unit: bar}}\n"


@contextlib.contextmanager
def folder_with(files):
    with tempfile.TemporaryDirectory() as name:
        for file, content in files.items():
            (Path(name) / file).write_bytes(content if isinstance(content, bytes) else content.encode())
        yield Path(name)


def read(content, name, description=USUAL):
    with folder_with({name: content, "m.yaml": f"files: {name}\n{description}"}) as folder:
        return list(measured_source(folder / "m.yaml").batches())


def read_or_refused(content, name, description=USUAL):
    """Read a file by its description and without; a mistake may be raised, and everything else is a fault."""
    with contextlib.suppress(HydrofdiError):
        return read(content, name, description)
    with contextlib.suppress(HydrofdiError), folder_with({name: content}) as folder:
        list(plain_source(folder / name, 1000.0).batches())
    return []


CHANNELS = st.sampled_from([channel for channel in Channel if channel.unit in UNITS])


@given(
    st.lists(CHANNELS, min_size=1, max_size=4, unique=True), st.data(),
    st.sampled_from([("\t", "tab"), (";", ";"), (",", ","), ("|", "|"), ("  ", "space")]),
    st.sampled_from(".,"), st.sampled_from(["[{}]", "({})", "row", "yaml"]), st.booleans(),
)  # fmt: skip
def test_any_table_of_numbers_comes_back_in_si(channels, data, delimiter, decimal, place, is_stated):
    sign, name = delimiter
    assume(sign != decimal and not (place == "row" and sign == "  "))
    rows = data.draw(st.lists(st.lists(FINITE, min_size=4, max_size=4), min_size=2, max_size=6))
    units = [data.draw(st.sampled_from(UNITS[channel.unit])) for channel in channels]
    above = data.draw(st.lists(st.sampled_from(["", "# x"]), max_size=3))
    titles = [f"c{n} {place.format(unit)}" if "{" in place else f"c{n}" for n, unit in enumerate(units)]
    head = [*above, sign.join(titles)] + [sign.join(units)] * (place == "row")
    body = [sign.join(repr(value).replace(".", decimal) for value in row[: len(units)]) for row in rows]
    described = ", ".join(
        f"{channel}: {{column: c{n}{f', unit: {unit}' * (place == 'yaml')}}}"
        for n, (channel, unit) in enumerate(zip(channels, units, strict=True))
    )
    form = f'decimal: "{decimal}"' + f', delimiter: "{name}"' * is_stated
    description = f"sampling_frequency: 1 kHz\nformat: {{{form}}}\nchannels: {{{described}}}\n"
    (batch,) = read("\n".join([*head, *body]) + "\n", "run.txt", description)
    for n, (channel, unit) in enumerate(zip(channels, units, strict=True)):
        factor = parse_unit(unit).factor
        expected = [row[n] * factor.numerator / factor.denominator for row in rows]
        tolerance = 0.0 if min(factor.numerator, factor.denominator) == 1 else 1e-15
        np.testing.assert_allclose(batch[channel][0], expected, rtol=tolerance, atol=0.0)


@settings(max_examples=150)
@given(st.binary(max_size=200) | st.text(max_size=200), st.sampled_from(["run.csv", "run.txt.gz"]))
@example("P1\n1\x00\n2\n", "run.csv")
@example('P1\n"1\n2\n', "run.csv")
@example("P1,P1\n1,2\n3,4", "run.csv")
@example("P1\n" + "9" * 5000 + "\n1\n", "run.csv")
@example("P1\n1e999\n2\n", "run.csv")
@example("\n\n\n", "run.csv")
@example("P1\r1\r2\r", "run.csv")
@example(b"\xff\xfeP\x001\x00", "run.csv")
def test_any_bytes_are_read_or_refused(content, name):
    data = content.encode("utf-8", "surrogatepass") if isinstance(content, str) else content
    read_or_refused(gzip.compress(data) if name.endswith("gz") else data, name)
    read_or_refused(data, name)


def sound(kind):
    target, values = io.BytesIO(), np.arange(64.0)
    if kind == "h5":
        with h5py.File(target, "w") as file:
            file["g/x"] = values
            file.create_dataset("P1", data=values, chunks=(16,), compression="gzip").attrs["units"] = "bar"
    elif kind == "npz":
        np.savez_compressed(target, P1=values)
    elif kind == "csv.gz":
        target.write(gzip.compress(("P1\n" + "\n".join(map(str, values)) + "\n").encode()))
    else:
        WRITERS[kind](target, {"P1": values} | {"s/a": 1.0} if kind == "mat" else {"P1": values})
    return target.getvalue()


@pytest.fixture(scope="module")
def impatient():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(opening, "SECONDS", 5.0)
        yield


@pytest.mark.parametrize("kind", ["mat", "h5", "npz", "parquet", "csv.gz"])
@settings(max_examples=80, derandomize=True)
@given(st.data())
def test_a_broken_file_gives_its_numbers_or_a_reason(impatient, kind, data):
    """The libraries of MAT and HDF5 crash or hang on some of these."""
    content = bytearray(sound(kind))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    stop = data.draw(st.integers(0, len(content)))
    for changed in (bytes(content), bytes(content[:stop])):
        for batch in read_or_refused(changed, f"run.{kind}"):
            assert batch.n_record + len(batch.rejected) == 1
            assert all(rejected.remark.message for rejected in batch.rejected)


@settings(max_examples=100)
@given(st.text(alphabet="fileschanp_1:{}[]\"',. \n#*0kHzbr", max_size=120))
def test_any_description_is_read_or_refused(text):
    read_or_refused("P1\n1\n2\n", "run.csv", text)
