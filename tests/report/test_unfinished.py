import json

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.config import load_experiment
from hydrofdi.papers import make_report
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.figures import draw_all
from hydrofdi.report.record import render_json
from hydrofdi.store.reading import write_request

HALF = """\
name: half
paper: maddahi2015
record: {duration: 2 s}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], fluid.bulk_modulus: [551 MPa]}}
"""
WHOLE = HALF.replace("[551 MPa]", "[551 MPa, 689 MPa]")


@pytest.fixture
def half_done(tmp_path, hydrofdi):
    """A sweep over two EBM of which one was computed before the program was killed."""
    config = tmp_path / "half.yaml"
    config.write_text(HALF)
    assert hydrofdi("sweep", config, "--engine", "in-process").returncode == 0
    config.write_text(WHOLE)
    directory = tmp_path / "results" / "half"
    write_request(directory, load_experiment(config))
    return directory


def test_an_unfinished_experiment_reports_what_is_there_and_why_the_rest_is_not(half_done):
    report = make_report(read_results(half_done))
    assert report.analysis.table.texts("status") == ["ok", "missing", "ok", "missing"]
    (holes,) = [block for block in report.document().blocks if block.key == "holes"]
    assert holes.paragraphs[0] == "2 of 4 runs have no results."
    assert "computes the missing runs" in holes.paragraphs[1]
    rows = json.loads(render_json(report))["rows"]
    assert [row["detail_rms_Pa"] == [None] * 5 for row in rows] == [False, True, False, True]


def test_a_figure_whose_run_is_missing_says_so_and_the_others_are_drawn(half_done):
    drawn, holes = draw_all(make_report(read_results(half_done)), ["figure2", "figure3"])
    assert list(drawn) == ["figure2"]
    assert "missing" in holes["figure3"]


def test_without_experiment_file_the_shards_are_reported(half_done):
    def found():
        table = Analysis(read_results(half_done)).table
        return table.of(table.is_ok)["detail_rms"].tolist()

    before = found()
    (half_done / "half.h5").unlink()
    assert before == found() != []


def test_an_experiment_without_any_result_is_all_holes(half_done):
    (half_done / "half.h5").unlink()
    for shard in (half_done / "shards").iterdir():
        shard.unlink()
    analysis = Study(read_results(half_done))
    assert {*analysis.table.texts("status")} == {"missing"}
    assert {result.reproduced for result in analysis.claims} == {None}
