"""Conclusions over the start phases, and of the settled records."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures import draw_figure
from hydrofdi.store.layout import names
from tests.commands import run_hydrofdi


@pytest.fixture(scope="module")
def record(table3):
    return json.loads(run_hydrofdi("report", "--json", cwd=table3.folder).stdout)


def test_the_claims_of_the_paper_hold_at_some_start_phases_only(record):
    held = {claim["id"]: claim["phases"]["held"] for claim in record["claims"]}
    assert {claim["phases"]["of"] for claim in record["claims"]} == {32}
    assert held["C2"] == 32
    assert 12 <= held["C1"] <= 20
    assert 20 <= held["C3"] <= 28
    assert 20 <= held["C4"] <= 28
    assert held["C5"] <= 12
    assert all(claim["reproduced"] for claim in record["claims"]), "at the paper's own phase"


def test_the_sealed_alarm_survives_every_phase_but_its_size_does_not(record):
    alarms = record["controls"]["sealed_alarms"]
    assert [alarm["phases"]["held"] for alarm in alarms] == [32, 32]
    assert [alarm["settled"]["phases"]["held"] for alarm in alarms] == [32, 32]
    spread = alarms[0]["phases"]["delta_d3_percent"]
    assert spread["largest"] - spread["least"] > 15.0


def test_margins_over_phases_are_those_of_sweeps_at_each_phase(table3, record, tmp_path):
    """The phase that ``analysis.discard`` gives by hand, one sample after the other."""
    settings = ["--set=wavelet.phase=0", "--set=analysis.discard=2 ms", "--set=name=late"]
    config = table3.config
    swept = run_hydrofdi("sweep", config, "--engine", "in-process", *settings, cwd=tmp_path)
    assert swept.returncode == 0, swept.stderr
    late = json.loads(run_hydrofdi("report", "results/late", "--json", cwd=tmp_path).stdout)
    margins = {claim["id"]: claim["margin_percentage_points"] for claim in late["claims"]}
    assert margins["C1"] == pytest.approx(-22.7, abs=0.3)
    assert {claim["phases"]["of"] for claim in late["claims"]} == {1}
    for claim in record["claims"]:
        spread = claim["phases"]["margin_percentage_points"]
        assert spread["least"] <= margins[claim["id"]] <= spread["largest"]


def test_a_settled_claim_is_free_of_boundaries_and_phases(record):
    (fifth,) = [claim for claim in record["claims"] if claim["id"] == "C5"]
    assert fifth["reproduced"] is True
    assert fifth["settled"]["reproduced"] is False
    assert fifth["settled"]["phases"]["held"] == 0


def test_both_of_two_deltas_may_move_by_half_of_their_difference(paper_analysis):
    (first,) = [result for result in paper_analysis.claims if result.claim.id == "C1"]
    assert first.allowance == pytest.approx(0.5 * first.margin)
    (fifth,) = [result for result in paper_analysis.claims if result.claim.id == "C5"]
    assert fifth.allowance == fifth.margin, "no difference: each δ against zero"


def test_a_phase_that_breaks_a_claim_is_counted(made_up):
    rms = made_up.columns[names.DETAIL_RMS]
    phases = np.repeat(rms[:, None], 32, axis=1)
    phases[2, 7, 1] *= 2.0  # d2 of the small leak at the normal EBM, at phase 7 alone
    data = replace(made_up, columns=made_up.columns | {names.PHASE_DETAIL_RMS: phases})
    study = Study(data)
    configured, settled = (each.claim("C1", study.looked_at) for each in study.standings)
    assert (configured.held, configured.of) == (31, 32)
    assert configured.values[7] < 0.0
    assert settled.of == 1


def test_records_that_have_not_settled_have_no_settled_claims(made_up):
    nothing = np.full_like(made_up.columns[names.DETAIL_RMS], np.nan)
    data = replace(made_up, columns=made_up.columns | {names.SETTLED_DETAIL_RMS: nothing})
    (configured,) = Study(data).standings
    assert configured.title == "as configured"
    assert not Study(data).table.has_settled


def test_the_figure_shows_the_range_of_every_claim_over_the_phases(paper_analysis, made_up):
    drawn = draw_figure(StudyReport(paper_analysis), "phases").axes
    ends = {
        tuple(path.vertices[:, 0])
        for axis in drawn
        for lines in axis.collections
        for path in lines.get_paths()
    }
    outcomes = [*paper_analysis.claim_outcomes, *paper_analysis.alarm_outcomes]
    assert ends == {(min(each.values), max(each.values)) for each in outcomes}
    with pytest.raises(ReportError, match="only one start phase"):
        draw_figure(StudyReport(Study(made_up)), "phases")
