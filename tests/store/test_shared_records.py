"""Runs that share a record: it is measured once, under its own identity."""

from __future__ import annotations

from pathlib import Path

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.api.stored import read_results
from hydrofdi.config import load_experiment
from hydrofdi.store.records import StoredRecords
from tests.conftest import sweep_in

_ANALYSES = """\
name: analyses
record: {duration: 2 s}
store: {signals: pressures}
analysis: {discard: 1 s}
sweep:
  grid:
    analysis.discard: [0 s, 1 s]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""


def test_records_have_the_identity_of_the_file_and_come_once(tmp_path: Path) -> None:
    swept = sweep_in(tmp_path, _ANALYSES)
    columns = read_results(swept.file).columns
    named = list(dict.fromkeys(columns["record_id"].astype(str)))
    assert len(columns["run_id"]) == 4
    assert len(named) == 2
    sources = [
        StoredRecords(read_results(swept.file), "file"),
        StoredRecords(read_results(swept.directory), "folder"),
        SimulatedRecords(load_experiment(swept.config), "simulated"),
    ]
    for source in sources:
        batches = list(source.batches(labels=True))
        assert [record for batch in batches for record in batch.record_ids] == named
        assert [label for batch in batches for label in batch.labels or ()] == [
            "sealed, 551 MPa",
            "sealed, 689 MPa",
        ]
