"""Records of a folder, their locks, and reading in parts."""

import os
import resource
import shutil
import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.api.stored import read_results
from hydrofdi.config import load_experiment
from hydrofdi.errors import StoreError
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.settings.quantities import Section
from hydrofdi.store import records
from hydrofdi.store.folder.lock import file_lock
from hydrofdi.store.records import StoredRecords
from tests.commands import run
from tests.conftest import sweep_in

MUSEUM = Path(__file__).parent.parent / "museum"
VERSIONS = ("format_4_physics_3",)


def stored(place: Path, **options: Any) -> StoredRecords:
    return StoredRecords(read_results(place), str(place), **options)


def all_of(source: RecordSource, channel: Channel = Channel.CHAMBER_1_PRESSURE) -> dict[str, np.ndarray]:
    """Record → samples of a channel."""
    return {
        record_id: samples
        for batch in source.batches()
        for record_id, samples in zip(batch.record_ids, batch[channel], strict=True)
    }


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["pressures.h5", "run.h5"])
def test_a_museum_file_measures_what_its_version_stored(version: str, name: str) -> None:
    source = stored(MUSEUM / version / name)
    (batch,) = source.batches()
    values = measure(batch, make_indicators(["dwt"])).values
    for level, rms in enumerate(source.data.columns["detail_rms"].T, 1):
        np.testing.assert_array_equal(values[f"dwt.d{level}"], rms)


def test_the_shards_of_a_folder_give_the_records_of_its_file(
    small_sweep: SimpleNamespace, tmp_path: Path
) -> None:
    folder = tmp_path / "small"
    shutil.copytree(small_sweep.directory, folder)
    (folder / small_sweep.file.name).unlink()
    for channel in (Channel.CHAMBER_1_PRESSURE, Channel.SUPPLY_PRESSURE, Channel.INPUT_VOLTAGE):
        file, shards = all_of(stored(small_sweep.file), channel), all_of(stored(folder), channel)
        assert list(file) == list(shards)
        np.testing.assert_array_equal(list(file.values()), list(shards.values()))


def test_simulated_records_are_those_that_are_stored(small_sweep: SimpleNamespace) -> None:
    simulated = SimulatedRecords(load_experiment(small_sweep.config), "small")
    for channel in (Channel.CHAMBER_2_PRESSURE, Channel.PISTON_VELOCITY, Channel.SPOOL_POSITION):
        made, kept = all_of(simulated, channel), all_of(stored(small_sweep.file), channel)
        assert list(made) == list(kept)
        np.testing.assert_array_equal(list(made.values()), list(kept.values()))
    labels = [
        [b.labels for b in source.batches(labels=True)] for source in (simulated, stored(small_sweep.file))
    ]
    assert labels[0] == labels[1]
    assert labels[0][0][0] == "sealed, 551 MPa"
    assert labels[0][0][2] == "K_i 1e-08 m³/s/√Pa, 551 MPa"


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
        assert rejected
        assert sum(batch.n_record for batch in batches) + len(rejected) == len(source_ids(source))
        assert all(
            batch[Channel.CHAMBER_1_PRESSURE].dtype == np.float64 for batch in batches if batch.n_record
        )


def source_ids(source: RecordSource) -> set[str]:
    batches = list(source.batches())
    return {i for batch in batches for i in batch.record_ids} | {
        reject.record_id for batch in batches for reject in batch.rejected
    }


def test_only_the_channels_asked_for_are_read(small_sweep: SimpleNamespace) -> None:
    wanted = {Channel.PISTON_POSITION, Channel.RETURN_PRESSURE}
    for source in (
        stored(small_sweep.file, channels=wanted),
        SimulatedRecords(load_experiment(small_sweep.config), "small", wanted),
    ):
        (batch,) = source.batches()
        assert batch.channels.keys() == {Channel.PISTON_POSITION}


def test_an_experiment_without_signals_says_which_setting_keeps_them() -> None:
    with pytest.raises(StoreError, match=r"store: \{signals: all\}"):
        list(stored(MUSEUM / "format_4_physics_3" / "kept").batches())


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


def test_nothing_of_the_parameters_can_be_reached_from_a_batch(small_sweep: SimpleNamespace) -> None:
    for source in (stored(small_sweep.file), SimulatedRecords(load_experiment(small_sweep.config), "small")):
        (batch,) = source.batches()
        assert isinstance(batch, RecordBatch)
        assert batch.labels is None
        kinds = {type(part) for part in reachable(batch)}
        assert kinds <= {RecordBatch, dict, tuple, frozenset, Channel, np.ndarray, str, float, type(None)}
        assert not any(issubclass(kind, Section) for kind in kinds)


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


def test_a_disk_that_is_full_at_the_start_of_a_sweep_is_one_line(tmp_path):
    def limit_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10))

    command = ("sweep", "smoke", "--out", "results")
    stopped = run(*command, cwd=tmp_path, check=2, preexec_fn=limit_files)
    assert [line.partition(": ")[0] for line in stopped.stderr.splitlines()].count("hydrofdi") == 1
    assert "Traceback" not in stopped.stderr
    run(*command, cwd=tmp_path, check=0)


FOUR = """\
name: many
record: {duration: 1 s}
store: {signals: pressures, dtype: float32}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-8]
    fluid.bulk_modulus: [551 MPa, 827 MPa]
"""

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


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    return sweep_in(tmp_path_factory.mktemp("many"), FOUR)


def repeated(file: Path, path: Path, n_run: int) -> Path:
    """An experiment file with the runs of another, again and again, each with an identity of its own."""
    with h5py.File(file) as source, h5py.File(path, "w") as target:
        target.attrs.update(source.attrs)
        for name, held in source.items():
            rows = held.shape[0]
            if name in ("run_id", "record_id"):
                target.create_dataset(name, data=[f"{row:016x}" for row in range(n_run)])
            elif name in ("time", "level"):
                target.create_dataset(name, data=held[:])
            else:
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


def test_memory_does_not_grow_with_the_records(four: SimpleNamespace, tmp_path: Path) -> None:
    few, more = (
        measured(repeated(four.file, tmp_path / f"{n_run}.h5", n_run), tmp_path / f"{n_run}.csv")
        for n_run in (1000, 20_000)
    )
    assert more < 500
    assert more - few < 40  # the chamber-1 pressures of the larger source alone are 80 MB
    with open(tmp_path / "20000.csv", encoding="utf-8") as lines:
        assert sum(1 for _ in lines) == 20_001
