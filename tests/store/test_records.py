"""Records of a folder, their locks, and reading in parts."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import StoreError
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.store import experiment_data as records
from hydrofdi.store.experiment_data import StoredRecords
from hydrofdi.store.folder import file_lock
from hydrofdi.store.results import read_results
from tests.conftest import sweep_in

MUSEUM = Path(__file__).parent.parent / "museum" / "format_4_physics_3"


def stored(place: Path, **options: Any) -> StoredRecords:
    return StoredRecords(read_results(place), str(place), **options)


def all_of(source: RecordSource, channel: Channel = Channel.CHAMBER_1_PRESSURE) -> dict[str, np.ndarray]:
    """Record → samples of a channel."""
    return {
        record_id: samples
        for batch in source.batches()
        for record_id, samples in zip(batch.record_ids, batch[channel], strict=True)
    }


@pytest.mark.parametrize("name", ["pressures.h5", "run.h5"])
def test_a_museum_file_measures_what_its_version_stored(name: str) -> None:
    source = stored(MUSEUM / name)
    (batch,) = source.batches()
    values = measure(batch, make_indicators(["dwt"])).values
    for level, rms in enumerate(source.data.columns["detail_rms"].T, 1):
        np.testing.assert_array_equal(values[f"dwt.d{level}"], rms)


@pytest.fixture
def sources(small_sweep: SimpleNamespace, tmp_path: Path) -> Callable[..., list[RecordSource]]:
    """The same records from an experiment file, from shards, and simulated; with options of each."""
    folder = tmp_path / "small"
    shutil.copytree(small_sweep.directory, folder)
    (folder / small_sweep.file.name).unlink()

    def made(**options: Any) -> list[RecordSource]:
        simulated = SimulatedRecords(load_experiment(small_sweep.config), "small", **options)
        return [stored(small_sweep.file, **options), stored(folder, **options), simulated]

    return made


def test_file_shards_and_simulation_give_the_same_records_and_nothing_of_their_parameters(sources) -> None:
    file, *others = sources()
    for channel in (Channel.CHAMBER_1_PRESSURE, Channel.SUPPLY_PRESSURE, Channel.INPUT_VOLTAGE):
        for other in others:
            one, same = all_of(file, channel), all_of(other, channel)
            assert list(one) == list(same)
            np.testing.assert_array_equal(list(one.values()), list(same.values()))
    for source in (file, *others):
        (batch,) = source.batches()
        assert batch.labels is None
        kinds = {type(part) for part in reachable(batch)}
        assert kinds <= {RecordBatch, dict, tuple, frozenset, Channel, np.ndarray, str, float, type(None)}
        (batch,) = source.batches(labels=True)
        assert batch.labels[0] == "sealed, 551 MPa"
        assert batch.labels[2] == "K_i 1e-08 m³/s/√Pa, 551 MPa"


def reachable(thing: Any) -> list[Any]:
    """Everything that can be got at from a batch."""
    inner: list[Any] = []
    if is_dataclass(thing):
        inner = [getattr(thing, field.name) for field in fields(thing)]
    elif isinstance(thing, dict):
        inner = [*thing, *thing.values()]
    elif isinstance(thing, tuple | list | frozenset):
        inner = list(thing)
    elif isinstance(thing, np.ndarray):
        inner = [thing.base]
    return [thing, *(part for content in inner for part in reachable(content))]


def test_only_the_channels_asked_for_are_read(sources) -> None:
    for source in sources(channels={Channel.PISTON_POSITION, Channel.RETURN_PRESSURE}):
        (batch,) = source.batches()
        assert batch.channels.keys() == {Channel.PISTON_POSITION}


TWO_DRIVES = """\
name: drives
record: {duration: 2 s}
store: {signals: pressures, dtype: float32}
sweep:
  grid:
    input.period: [1 s, 2 s]
    fluid.bulk_modulus: [551 MPa, 1e7 MPa, 827 MPa]
"""


def test_batches_have_one_drive_and_runs_that_failed_are_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    swept = sweep_in(tmp_path, TWO_DRIVES)
    for source in (stored(swept.file), SimulatedRecords(load_experiment(swept.config), "drives")):
        monkeypatch.setattr(records, "_MOST_RECORDS", 4)
        batches = list(source.batches(labels=True))
        assert {batch.drive_period for batch in batches} == {1.0, 2.0}
        rejected = [reject for batch in batches for reject in batch.rejected]
        assert [(reject.remark.kind, reject.label) for reject in rejected] == [
            ("diverged", "sealed, 1e+07 MPa")
        ] * len({reject.record_id for reject in rejected})
        identities = {each for batch in batches for each in batch.record_ids}
        identities |= {reject.record_id for reject in rejected}
        assert sum(batch.n_record for batch in batches) + len(rejected) == len(identities) > len(rejected) > 0
        assert all(
            batch[Channel.CHAMBER_1_PRESSURE].dtype == np.float64 for batch in batches if batch.n_record
        )


def test_an_experiment_without_signals_says_which_setting_keeps_them() -> None:
    with pytest.raises(StoreError, match=r"store: \{signals: all\}"):
        list(stored(MUSEUM / "kept").batches())


@pytest.mark.parametrize("content", ["", "notes"])
@pytest.mark.parametrize("is_link", [True, False])
def test_a_lock_neither_follows_links_nor_empties_what_is_no_lock(content, is_link, tmp_path):
    lock = victim = tmp_path / ".lock"
    if is_link:
        victim = tmp_path / "victim"
        lock.symlink_to(victim)
    victim.write_text(content)
    if not is_link and not content:
        with file_lock(lock, "in use") as holder:
            assert holder == ""
    else:
        with pytest.raises(StoreError), file_lock(lock, "in use"):
            pass
    assert victim.read_text() == content


MEASURED = """
import re, sys
from hydrofdi.cli.app import main
try:
    main()
except SystemExit as end:
    peak = re.search(r"VmHWM:\\s*(\\d+) kB", open("/proc/self/status").read())[1]
    sys.stderr.write(f"\\n{end.code} {peak}\\n")
"""
"""Prints the exit code, and the peak of the resident memory in kB; ``ru_maxrss`` would count the parent's."""


def repeated(path: Path, n_run: int) -> Path:
    """An experiment file with the runs of another, again and again, each with an identity of its own."""
    with h5py.File(MUSEUM / "pressures.h5") as source, h5py.File(path, "w") as target:
        target.attrs.update(source.attrs)
        for name, held in source.items():
            rows = held.shape[0]
            if name in ("run_id", "record_id"):
                target.create_dataset(name, data=[f"{row:016x}" for row in range(n_run)])
            elif name in ("time", "level"):
                target.create_dataset(name, data=held[:])
            elif name != "chamber_2_pressure":
                many = target.create_dataset(name, (n_run, *held.shape[1:]), held.dtype)
                block = np.concatenate([held[:]] * (1000 // rows))
                for first in range(0, n_run, len(block)):
                    many[first : first + len(block)] = block[: n_run - first]
    return path


def measured(file: Path, out: Path) -> int:
    """Measure in a process of its own; the peak of its resident memory [MB]."""
    command = [sys.executable, "-c", MEASURED, "measure", str(file), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1200, env=os.environ)
    code, peak = done.stderr.splitlines()[-1].split()
    assert code == "0", done.stderr
    return int(peak) // 1024


def test_memory_does_not_grow_with_the_records(tmp_path: Path) -> None:
    few, more = (
        measured(repeated(tmp_path / f"{n_run}.h5", n_run), tmp_path / f"{n_run}.csv")
        for n_run in (1000, 20_000)
    )
    assert more < 500
    assert more - few < 40  # the chamber-1 pressures of the larger source alone are 80 MB
    with open(tmp_path / "20000.csv", encoding="utf-8") as lines:
        assert sum(1 for _ in lines) == 20_001
