"""Verdicts of runs in a report: marks where a run is to be read with care, silence where none is."""

import json

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ReportError
from hydrofdi.papers import make_report
from hydrofdi.report.figures import draw_all, write_figure
from hydrofdi.report.page import render_json, write_all_forms
from hydrofdi.store.folder import write_request
from hydrofdi.store.results import read_results
from tests.commands import run_json
from tests.conftest import SMALL, sweep_in


def blocks(data):
    return {block.key: block for block in make_report(data).document().blocks}


def test_verdicts_are_reported_with_count_and_largest_number_and_mark_their_rows_and_sound_runs_have_none(
    made_up, small_sweep
):
    found = blocks(made_up)
    (table,) = found["doubts"].tables
    assert table["runs"].tolist() == [1, 1, 1]
    assert "15 %" in table["meaning"][1]
    for sheet in found["table3"].tables:
        assert [*sheet["Verdict"]] == ["", "U", "", "C A", "", ""]
    sound = blocks(read_results(small_sweep.directory))
    assert "doubts" not in sound
    for sheet in sound["changes"].tables:
        assert "Verdict" not in [column.heading for column in sheet.shown]
        assert not sheet.notes


STILL = SMALL.replace("sweep:", "paper: maddahi2015\ninput: {amplitude: 0 V}\nsweep:")


def test_no_change_and_no_claim_is_made_of_records_that_stand_still(tmp_path):
    sweep = sweep_in(tmp_path, STILL)
    record = run_json("report", sweep.directory)
    assert "Warning" not in sweep.result.stderr
    assert {row["verdict"] for row in record["rows"]} == {"still"}
    assert {value for row in record["rows"] for value in row["delta_fixed_percent"]} == {None}
    assert {claim["reproduced"] for claim in record["claims"]} == {None}


HALF = """\
name: half
paper: maddahi2015
record: {duration: 2 s}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], fluid.bulk_modulus: [551 MPa]}}
"""


def test_an_unfinished_experiment_reports_and_draws_what_is_there_and_why_the_rest_is_not(tmp_path):
    """A sweep over two EBM of which one was computed before the program was killed."""
    half = sweep_in(tmp_path, HALF)
    half.config.write_text(HALF.replace("[551 MPa]", "[551 MPa, 689 MPa]"))
    write_request(half.directory, load_experiment(half.config))
    report = make_report(read_results(half.directory))
    assert report.table.texts("status") == ["ok", "missing", "ok", "missing"]
    (holes,) = [block for block in report.document().blocks if block.key == "holes"]
    assert holes.tables[0]["runs"].tolist() == [2]
    rows = json.loads(render_json(report))["rows"]
    assert [row["detail_rms_Pa"] == [None] * 5 for row in rows] == [False, True, False, True]
    drawn, holes = draw_all(report, ["figure2", "figure3"])
    assert list(drawn) == ["figure2"]
    assert "missing" in holes["figure3"]


GENERAL = """\
name: none
record: {duration: 2 s}
sweep: {grid: {leakage.internal_coefficient: [1.0e-9, 1.0e-8], supply.pressure: [15 MPa, 16 MPa, 17 MPa]}}
"""
PAPER = "paper: maddahi2015\n" + GENERAL
STUDY = """\
name: none
record: {duration: 2 s}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 30, test: 20}
  faults: {leakage.internal_flow: [0.02 L/min, 2 L/min], each: 15}
detection: {false_alarm_rate: 10 %, probability: 80 %, indicators: [dwt]}
"""


@pytest.mark.parametrize("text", [GENERAL, PAPER, STUDY], ids=["general", "paper", "study"])
def test_it_says_what_is_missing_and_the_remedy_and_shows_no_empty_tables(tmp_path, text):
    """Of a sweep that was asked for, before its first run."""
    config = tmp_path / "none.yaml"
    config.write_text(text)
    write_request(tmp_path / "none", load_experiment(config))
    report = make_report(read_results(tmp_path / "none"))
    document = report.document()
    assert {block.key for block in document.blocks} <= {"remarks", "holes", "provenance"}
    assert not document.figures
    (holes,) = [block for block in document.blocks if block.key == "holes"]
    assert holes.tables[0]["status"].tolist() == ["missing"]
    with pytest.raises(ReportError):
        write_figure(report, tmp_path / "answer.png")
    assert not [line for line in write_all_forms(report, tmp_path / "out") if "left out" in line]
