"""The report of a study whose sweep is not finished."""

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.execution import InProcessEngine
from hydrofdi.papers import make_report
from hydrofdi.store.reading import write_request

STUDY = """
name: half-study
record: {duration: 2 s}
input: {period: 0.5 s}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}
  healthy: {fit: 30, test: 20}
  faults: {leakage.internal_flow: [0.02 L/min, 2 L/min], each: 15, fit: 5}
detection: {false_alarm_rate: 10 %, probability: 80 %, indicators: [dwt]}
"""
LARGER = ("study.healthy.fit=60", "study.sensitivity.alone=49")


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """90 runs are stored, and many more are asked for, of a Sobol design none."""
    folder = tmp_path_factory.mktemp("half")
    file = folder / "study.yaml"
    file.write_text(STUDY)
    run_sweep(load_experiment(file), folder / "out", InProcessEngine())
    write_request(folder / "out", load_experiment(file, LARGER))
    return make_report(read_results(folder / "out"))


def test_an_unfinished_study_says_so_first_and_concludes_nothing(report):
    document = report.document()
    assert document.blocks[0].key == "progress"
    assert document.blocks[0].paragraphs[0].startswith(f"90 of {report.data.n_run:,} runs are computed")
    answer = next(block for block in document.blocks if block.key == "answer")
    assert "confidence" not in " ".join(answer.paragraphs)
    assert {"why", "designs", "holes"}.isdisjoint(block.key for block in document.blocks)


def test_its_json_counts_what_is_there(report):
    record = report.record()
    assert (record["is_complete"], record["runs_computed"]) == (False, 90)
    (study,) = record["studies"]
    assert sum(each["n"] for each in study["populations"]) == 90
    assert all(one["threshold"]["n"] == 30 for one in record["detection"])
