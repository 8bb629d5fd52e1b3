"""Sweeps whose leakage or EBM is drawn: rows without a grid of modes."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.papers.maddahi2015.claims import CLAIMS
from hydrofdi.papers.maddahi2015.controls import alarm_verdicts
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report import runs
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.experiment_file import requested_columns
from hydrofdi.store.layout import names
from hydrofdi.store.signals import FileSignals
from hydrofdi.transforms.wavelet import percentage_change
from tests.conftest import run_hydrofdi, sweep_in

N_DRAWN = 100
BOTH = """\
name: both
paper: maddahi2015
record: {duration: 1 s}
store: {signals: none}
sweep:
  sample:
    method: random
    count: %d
    over:
      fluid.bulk_modulus: {uniform: [400 MPa, 900 MPa]}
      leakage.internal_coefficient: {loguniform: [1e-9, 1e-8]}
"""
APART = "name: apart\nsweep: {zip: {fluid.bulk_modulus: {linspace: [400 MPa, 900 MPa, 200]}, %s}}\n"
LEAKAGE = "leakage.internal_coefficient: {linspace: [1e-9, 1e-8, 200]}"
FRICTION = "friction.viscous: {linspace: [50, 250, 200]}"
CHOSEN = """\
name: chosen
sweep:
  grid: {leakage.internal_coefficient: [1e-9, 1e-8]}
  sample: {count: 16, over: {fluid.bulk_modulus: {choice: [551 MPa, 689 MPa, 827 MPa]}}}
"""


def made(folder: Path, text: str) -> ExperimentData:
    """An experiment with numbers drawn by hand and no signals."""
    config = folder / "made.yaml"
    config.write_text(text, encoding="utf-8")
    experiment = load_experiment(config)
    runs = expand_runs(experiment)
    n_run, draw = len(runs.runs), np.random.default_rng(0)
    columns = {
        variable.name: np.full(n_run, "ok")
        if variable.is_text
        else draw.uniform(1.0, 2.0, (n_run, 5) if names.LEVEL in variable.dimensions else n_run)
        for variable in (*names.stored_variables("none"), *names.BY_LEVEL[:2])
    } | requested_columns(runs)
    return ExperimentData(folder / "made.h5", experiment, columns, {}, FileSignals(folder / "made.h5"))


def sentences(analysis, key):
    return next(block for block in StudyReport(analysis).document().blocks if block.key == key).paragraphs


@pytest.mark.parametrize("text", [BOTH % 200, APART % LEAKAGE, APART % FRICTION])
def test_runs_that_share_neither_leakage_nor_bulk_modulus_are_no_grid(tmp_path, text):
    analysis = Study(made(tmp_path, text))
    assert analysis.grid.positions.size == 1
    assert sentences(analysis, "claims") == (analysis.grid.lack,)
    assert [result.reproduced for result in analysis.claims] == [None] * len(CLAIMS)


def test_the_controls_look_at_every_run_where_there_is_no_grid(tmp_path):
    analysis = Study(made(tmp_path, BOTH % 200))
    table = analysis.table
    raised = table.of(table.is_sealed & (table[names.BULK_MODULUS] > 551e6))
    assert {*analysis.sealed.positions} == {*raised.positions}
    assert len(raised) > 100
    assert len(analysis.leaky) == 200
    delta = analysis.sealed.changes("fixed")
    assert alarm_verdicts(delta) == [d[2] > 0.0 and d[2] == max(d) for d in delta]


def test_chosen_values_that_meet_are_a_grid(tmp_path):
    analysis = Study(made(tmp_path, CHOSEN))
    assert analysis.grid.lack == ""
    assert len(analysis.grid.modes()) == 6


def test_the_arrays_of_all_runs_are_gone_through_equally_often_for_more_runs(tmp_path, monkeypatch):
    passes = []
    monkeypatch.setattr(runs, "percentage_change", lambda *a: passes.append(0) or percentage_change(*a))
    counts = []
    for n_run in (20, 200):
        StudyReport(Study(made(tmp_path, BOTH % n_run))).document()
        counts.append(len(passes))
        passes.clear()
    assert counts[0] == counts[1] > 0


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("drawn"), BOTH % N_DRAWN)


def reported(drawn, *arguments):
    result = run_hydrofdi("report", drawn.directory, *arguments, cwd=drawn.folder)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_the_forms_for_programs_hold_every_row(drawn):
    n_run = drawn.summary["planned"]
    record = json.loads(reported(drawn, "--json"))
    assert len(record["rows"]) == n_run
    assert record["claims_not_evaluated"]
    lines = list(csv.DictReader(io.StringIO(reported(drawn, "--format", "csv"))))
    assert len(lines) == 5 * n_run
    assert {line["run_id"] for line in lines} == {row["run_id"] for row in record["rows"]}
