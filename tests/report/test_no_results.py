"""The report of an experiment of which no run has results."""

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.config import load_experiment
from hydrofdi.errors import ReportError
from hydrofdi.papers import make_report
from hydrofdi.report.figures import write_figure
from hydrofdi.report.publication import write_all_forms
from hydrofdi.store.reading import write_request
from tests.commands import run_hydrofdi

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
SAID = {"remarks", "holes", "progress", "varied", "provenance"}


def asked_for(folder, text):
    """The folder of a sweep that was asked for, before its first run."""
    config = folder / "none.yaml"
    config.write_text(text)
    write_request(folder / "none", load_experiment(config))
    return folder / "none"


@pytest.mark.parametrize("text", [GENERAL, PAPER, STUDY], ids=["general", "paper", "study"])
def test_it_says_what_is_missing_and_the_remedy_and_shows_no_empty_tables(tmp_path, text):
    report = make_report(read_results(asked_for(tmp_path, text)))
    document = report.document()
    assert {block.key for block in document.blocks} <= SAID
    assert not document.figures
    assert "computes the" in " ".join(document.blocks[0].paragraphs)
    with pytest.raises(ReportError, match="nothing to draw: no run has results"):
        write_figure(report, tmp_path / "answer.png")
    assert not [line for line in write_all_forms(report, tmp_path / "out") if "left out" in line]


def test_the_first_page_lists_a_few_missing_runs_and_full_lists_all(tmp_path):
    folder = asked_for(tmp_path, GENERAL)
    first, full = (run_hydrofdi("report", folder, *more).stdout for more in ((), ("--full",)))
    assert "9 of 9 runs have no results" in first
    assert full.count("not computed yet") == 9
    for leakage, count in (("sealed", 3), ("K_i 1e-09", 3), ("K_i 1e-08", 3)):
        listed = [line for line in full.splitlines() if line.strip().startswith(leakage)]
        assert len(listed) == count, leakage
