"""The paper's study over start phases and drawn parameters."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.claims import CLAIMS
from hydrofdi.papers.maddahi2015.report import StudyReport, alarm_verdicts
from hydrofdi.report.figures import draw_figure
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.experiment_file import requested_columns
from hydrofdi.store.shards import FileSignals
from tests.commands import run, run_json


def test_margins_over_phases_are_those_of_sweeps_at_each_phase(table3, tmp_path):
    """The phase that ``analysis.discard`` gives by hand, one sample after the other."""
    settings = ["--set=wavelet.phase=0", "--set=analysis.discard=2 ms", "--set=name=late"]
    run("sweep", table3.config, "--engine", "in-process", *settings, cwd=tmp_path, check=0)
    late = run_json("report", "results/late", cwd=tmp_path)
    margins = {claim["id"]: claim["margin_percentage_points"] for claim in late["claims"]}
    assert margins["C1"] == pytest.approx(-22.7, abs=0.3)
    assert {claim["phases"]["of"] for claim in late["claims"]} == {1}
    for claim in run_json("report", cwd=table3.folder)["claims"]:
        spread = claim["phases"]["margin_percentage_points"]
        assert spread["least"] <= margins[claim["id"]] <= spread["largest"]


def test_a_phase_that_breaks_a_claim_is_counted(made_up):
    rms = made_up.columns[names.DETAIL_RMS]
    phases = np.repeat(rms[:, None], 32, axis=1)
    phases[2, 7, 1] *= 2.0  # d2 of the small leak at the normal EBM, at phase 7 alone
    data = replace(made_up, columns=made_up.columns | {names.PHASE_DETAIL_RMS: phases})
    study = StudyReport(data)
    configured, settled = (each.claim("C1", study.looked_at) for each in study.standings)
    assert (configured.held, configured.of) == (31, 32)
    assert configured.values[7] < 0.0
    assert settled.of == 1


def test_records_that_have_not_settled_have_no_settled_claims(made_up):
    nothing = np.full_like(made_up.columns[names.DETAIL_RMS], np.nan)
    study = StudyReport(replace(made_up, columns=made_up.columns | {names.SETTLED_DETAIL_RMS: nothing}))
    assert [standing.title for standing in study.standings] == ["as configured"]
    assert not study.table.has_settled


def test_the_figure_shows_the_range_of_every_claim_over_the_phases(paper_analysis, made_up):
    drawn = draw_figure(paper_analysis, "phases").axes
    paths = [path for axis in drawn for lines in axis.collections for path in lines.get_paths()]
    outcomes = [*paper_analysis.claim_outcomes, *paper_analysis.alarm_outcomes]
    assert {tuple(path.vertices[:, 0]) for path in paths} == {
        (min(each.values), max(each.values)) for each in outcomes
    }
    with pytest.raises(ReportError, match="only one start phase"):
        draw_figure(StudyReport(made_up), "phases")


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
CHOSEN = (
    "name: chosen\nsweep: {grid: {leakage.internal_coefficient: [1e-9, 1e-8]}, "
    "sample: {count: 16, over: {fluid.bulk_modulus: {choice: [551 MPa, 689 MPa, 827 MPa]}}}}\n"
)


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
    } | {each.name: values for each, values in requested_columns(runs).items()}
    return ExperimentData(folder / "made.h5", experiment, columns, {}, FileSignals(folder / "made.h5"))


@pytest.mark.parametrize("text", [BOTH % 200, APART % LEAKAGE, APART % FRICTION])
def test_runs_that_share_neither_leakage_nor_bulk_modulus_are_no_grid(tmp_path, text):
    analysis = StudyReport(made(tmp_path, text))
    assert analysis.grid.positions.size == 1
    (block,) = [block for block in analysis.document().blocks if block.key == "claims"]
    assert block.paragraphs == (analysis.grid.lack,)
    assert [result.reproduced for result in analysis.claims] == [None] * len(CLAIMS)
    chosen = StudyReport(made(tmp_path, CHOSEN)).grid
    assert (chosen.lack, len(chosen.modes())) == ("", 6)


def test_the_controls_look_at_every_run_where_there_is_no_grid(tmp_path):
    analysis = StudyReport(made(tmp_path, BOTH % 200))
    table = analysis.table
    raised = table.of(table.is_sealed & (table[names.BULK_MODULUS] > 551e6))
    assert {*analysis.sealed.positions} == {*raised.positions}
    assert len(raised) > 100
    delta = analysis.sealed.changes("fixed")
    assert alarm_verdicts(delta) == [d[2] > 0.0 and d[2] == max(d) for d in delta]
    assert alarm_verdicts(np.full((1, 5), np.nan)) == [None]
    assert analysis.record()["claims_not_evaluated"]
