"""MDF4, TDMS, compound HDF5 and dSPACE structures: channels at their own rates, in the units of the file."""

import sys
from datetime import UTC, datetime, timedelta

import h5py
import numpy as np
import pytest
import scipy.io

from hydrofdi.errors import DataError
from hydrofdi.records import files as opening
from hydrofdi.records.source import measured_source, plain_source, write_description
from tests.records.dialects import RATE, ROWS, TIME
from tests.records.measuring import P1, P2, POSITION, VOLTAGE, batches, one, read, yaml_of

CHANNELS = {
    "P1": (P1, "bar", 1e5, 1),
    "P2": (P2, "bar", 1e5, 2),
    "x": (POSITION, "mm", 1e-3, 3),
    "u": (VOLTAGE, "V", 1.0, 4),
}
"""Name → channel, unit, factor to SI, and column of `ROWS`."""
START = datetime(2026, 5, 5, 22, 0, 0, 250_000, UTC)


def mdf(file, slow=(), late=3e-4):
    """Channels at 500 Hz, and others at 100 Hz in a group of their own that begins later."""
    library = pytest.importorskip("asammdf")
    with library.MDF() as written:
        written.start_time = written.header.start_time = START
        for names, every, start in ((CHANNELS.keys() - set(slow), 1, 0.0), (slow, 5, late)):
            signals = [
                library.Signal(ROWS[::every, column], TIME[::every] + start, unit, name)
                for name, (_, unit, _, column) in CHANNELS.items()
                if name in names
            ]
            if signals:
                written.append(signals, comment="rig")
        written.save(file)


def tdms(file, slow=(), late=0.0):
    """The same, where slow channels have a start of their own."""
    library = pytest.importorskip("nptdms")
    channels = []
    for name, (_, unit, _, column) in CHANNELS.items():
        every = 5 if name in slow else 1
        start = START + timedelta(seconds=late * (name in slow))
        waveform = {"wf_increment": every / RATE, "wf_start_offset": 0.0, "unit_string": unit}
        waveform["wf_start_time"] = start.replace(tzinfo=None)
        channels.append(library.ChannelObject("rig", name, ROWS[::every, column], waveform))
    with library.TdmsWriter(str(file)) as writer:
        writer.write_segment(channels)


WRITERS = {"run.mf4": mdf, "run.tdms": tdms}


def require_right(batch, names=CHANNELS):
    assert batch.sampling_frequency == RATE
    for channel, _, factor, column in (CHANNELS[name] for name in names):
        np.testing.assert_allclose(batch[channel][0], ROWS[:, column] * factor, rtol=1e-12)


@pytest.mark.parametrize("name", WRITERS)
def test_units_names_and_date_come_from_the_file(tmp_path, name):
    WRITERS[name](tmp_path / name)
    batch = read(plain_source(tmp_path / name))
    require_right(batch)
    assert batch.dates == pytest.approx([START.timestamp()], abs=1e-3)
    write_description(tmp_path / name, tmp_path / "rig.yaml")
    require_right(read(measured_source(tmp_path / "rig.yaml")))
    require_right(read(plain_source(tmp_path)))


@pytest.mark.parametrize(("name", "late"), [("run.mf4", 3e-4), ("run.tdms", 0.0), ("run.tdms", 0.1)])
def test_slow_channels_are_interpolated_at_the_instants_of_the_fast_ones(tmp_path, name, late):
    """From the instant on at which the last of them begins."""
    WRITERS[name](tmp_path / name, ["x"], late)
    batch = read(plain_source(tmp_path / name))
    assert batch.sampling_frequency == RATE
    assert {each.where for each in batch.remarks[0] if each.kind == "held"} == {POSITION}
    first = round(batch.start_time * RATE)
    assert first == np.ceil(late * RATE)
    assert batch.dates == (pytest.approx(START.timestamp() + first / RATE, abs=1e-6),)
    part = slice(first, first + batch.n_time)
    assert batch.n_time >= TIME.size - 6 - first
    np.testing.assert_allclose(batch[P1][0], ROWS[part, 1] * 1e5, rtol=1e-12)
    expected = np.interp(TIME[part], TIME[::5] + late, ROWS[::5, 3] * 1e-3)
    np.testing.assert_allclose(batch[POSITION][0], expected, rtol=1e-9)


@pytest.mark.parametrize(("name", "extra"), [("run.tdms", "measurement"), ("run.parquet", "parquet")])
def test_without_the_extra_it_says_what_to_install(tmp_path, monkeypatch, name, extra):
    monkeypatch.setattr(opening, "find_spec", lambda _: None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(DataError, match=rf"hydrofdi\[{extra}\]"):
        plain_source(tmp_path / name)


@pytest.mark.parametrize("name", WRITERS)
def test_a_damaged_file_is_rejected_alone(tmp_path, name):
    WRITERS[name](tmp_path / name)
    whole = (tmp_path / name).read_bytes()
    damaged = whole[: len(whole) // 3], b"TDSm" + bytes(500), b"MDF     4.10" + bytes(500)
    for number, data in enumerate(damaged):
        (tmp_path / f"{number}{name[3:]}").write_bytes(data)
    time = "time: {column: time, unit: s}"
    records = batches(tmp_path, yaml_of("P1: P1", files=f"'*{name[3:]}'", sampling=time))
    assert sum(batch.n_record for batch in records) + sum(len(batch.rejected) for batch in records) == 4
    assert {each.remark.kind for batch in records for each in batch.rejected} <= {"damaged", "time", "short"}
    assert f"{name}" in [each for batch in records for each in batch.record_ids]


def test_fields_of_a_compound_dataset_are_columns(tmp_path):
    table = np.zeros(TIME.size, dtype=[("t", "f8"), ("P1", "f8"), ("n", "i4")])
    table["t"], table["P1"] = TIME, ROWS[:, 1]
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["rig/table"] = table
    channels, time = "P1: {column: rig/table/P1, unit: bar}", "time: {column: rig/table/t, unit: s}"
    require_right(one(tmp_path, yaml_of(channels, files="run.h5", sampling=time)), ["P1"])


def test_signals_of_dspace_are_named_by_their_names(tmp_path):
    signals = [
        {"Name": f'"Model Root"/{name}', "Data": ROWS[:, column], "Unit": unit}
        for name, (_, unit, _, column) in CHANNELS.items()
    ]
    recorded = {"X": [{"Name": "time", "Data": TIME}], "Y": signals}
    scipy.io.savemat(tmp_path / "run.mat", {"rec": recorded})
    scaled = ", ".join(
        f"{name}: {{column: rec/Y/{name}, unit: {unit}}}" for name, (_, unit, *_) in CHANNELS.items()
    )
    time = "time: {column: rec/X/time, unit: s}"
    require_right(one(tmp_path, yaml_of(scaled, files="run.mat", sampling=time)))
    text = write_description(tmp_path / "run.mat", tmp_path / "proposed.yaml")
    assert "chamber_2_pressure: {column: 'rec/Y/P2', unit: …}" in text
