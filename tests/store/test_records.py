"""Records of a folder, their locks, and reading in parts."""

import shutil
import tracemalloc
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import StoreError
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordSource
from hydrofdi.store import experiment_data as records
from hydrofdi.store.experiment_data import StoredRecords
from hydrofdi.store.folder import file_lock
from hydrofdi.store.results import read_results
from tests.commands import run
from tests.conftest import sweep_in

MUSEUM = Path(__file__).parent.parent / "museum" / "format_4_physics_3"


def stored(place: Path, **options: Any) -> StoredRecords:
    return StoredRecords(read_results(place), str(place), **options)


@pytest.mark.parametrize("name", ["pressures.h5", "run.h5"])
def test_a_museum_file_measures_what_its_version_stored(name: str) -> None:
    source = stored(MUSEUM / name)
    (batch,) = source.batches()
    values = measure(batch, make_indicators(["dwt"])).values
    for level, rms in enumerate(source.data.columns["detail_rms"].T, 1):
        np.testing.assert_array_equal(values[f"dwt.d{level}"], rms)


def test_file_shards_and_simulation_give_the_same_records_of_the_channels_asked_for(
    small_sweep, tmp_path
) -> None:
    folder = tmp_path / "small"
    shutil.copytree(small_sweep.directory, folder)
    (folder / small_sweep.file.name).unlink()
    experiment = load_experiment(small_sweep.config)

    def sources(**options: Any) -> list[RecordSource]:
        stored_ones = [stored(place, **options) for place in (small_sweep.file, folder)]
        return [*stored_ones, SimulatedRecords(experiment, "small", **options)]

    first, *others = (next(source.batches(labels=True)) for source in sources())
    assert (first.labels[0], first.labels[2]) == ("sealed, 551 MPa", "K_i 1e-08 m³/s/√Pa, 551 MPa")
    for other in others:
        assert (other.record_ids, other.labels) == (first.record_ids, first.labels)
        for channel in (Channel.CHAMBER_1_PRESSURE, Channel.SUPPLY_PRESSURE, Channel.INPUT_VOLTAGE):
            np.testing.assert_array_equal(other[channel], first[channel])
    for source in sources(channels={Channel.PISTON_POSITION, Channel.RETURN_PRESSURE}):
        (batch,) = source.batches()
        assert batch.channels.keys() == {Channel.PISTON_POSITION}
        assert batch.labels is None


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


def test_memory_does_not_grow_with_the_records(tmp_path: Path) -> None:
    """The runs of a file again and again, each with an identity of its own; 80 MB of chamber-1 pressures."""
    n_run = 20_000
    with h5py.File(MUSEUM / "pressures.h5") as source, h5py.File(tmp_path / "many.h5", "w") as target:
        target.attrs.update(source.attrs)
        for name, held in source.items():
            if name in ("run_id", "record_id"):
                target.create_dataset(name, data=[f"{row:016x}" for row in range(n_run)])
            elif name in ("time", "level"):
                target.create_dataset(name, data=held[:])
            elif name != "chamber_2_pressure":
                many = target.create_dataset(name, (n_run, *held.shape[1:]), held.dtype)
                block = np.concatenate([held[:]] * (1000 // len(held)))
                for first in range(0, n_run, len(block)):
                    many[first : first + len(block)] = block[: n_run - first]
    tracemalloc.start()
    run("measure", tmp_path / "many.h5", "--out", tmp_path / "many.csv", check=0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 60e6
    with open(tmp_path / "many.csv", encoding="utf-8") as lines:
        assert sum(1 for _ in lines) == n_run + 1
