"""Stored and simulated runs as records."""

from __future__ import annotations

import shutil
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

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
from hydrofdi.store.records import StoredRecords
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
