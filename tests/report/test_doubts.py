"""Verdicts of runs in a report: marks where a run is to be read with care, silence where none is."""

import csv
import io
import json

from hydrofdi.api.stored import read_results
from hydrofdi.papers import make_report
from tests.commands import run_hydrofdi
from tests.conftest import SMALL, sweep_in


def blocks(data):
    return {block.key: block for block in make_report(data).document().blocks}


def test_a_report_of_sound_runs_says_nothing_of_verdicts(small_sweep):
    found = blocks(read_results(small_sweep.directory))
    assert "doubts" not in found
    for sheet in found["changes"].tables:
        assert "Verdict" not in [column.heading for column in sheet.shown]
        assert not sheet.notes


def test_each_verdict_is_reported_with_its_count_and_the_largest_number_behind_it(made_up):
    lead, *lines = blocks(made_up)["doubts"].paragraphs
    assert lead.startswith("2 of 6 runs have results to read with care")
    assert [line.split(",")[0] for line in lines] == ["cavitating (C)", "above_supply (A)", "unsettled (U)"]
    assert "15 %" in lines[1]
    assert "0.12 L/min at 689 MPa" in lines[1]


def test_a_row_has_the_marks_of_its_verdict_and_a_failed_one_none(made_up):
    for sheet in blocks(made_up)["table3"].tables:
        assert [*sheet["Verdict"]] == ["", "U", "", "C A", "", ""]
        assert sheet.notes == ("Verdict: C cavitating, A above_supply, U unsettled.",)


def test_all_forms_tell_runs_below_the_vapour_limit(tmp_path):
    text = SMALL.replace("sweep:", "fluid: {vapour_pressure: 5 MPa}\nsweep:")
    sweep = sweep_in(tmp_path, text)

    def printed(form):
        return run_hydrofdi("report", sweep.directory, "--full", "--format", form, cwd=tmp_path).stdout

    record = json.loads(printed("json"))
    assert [row["verdict"] for row in record["rows"]] == ["cavitating"] * 4
    assert record["verdicts"] == {"cavitating": 4}
    assert {line["verdict"] for line in csv.DictReader(io.StringIO(printed("csv")))} == {"cavitating"}
    for form in ("text", "markdown"):
        assert "C cavitating" in printed(form)
    assert "4 of 4 runs have results" in printed("text")


STILL = SMALL.replace("sweep:", "paper: maddahi2015\nvalve: {lap: 1 mm}\nsweep:")


def test_no_change_and_no_claim_is_made_of_records_that_stand_still(tmp_path):
    sweep = sweep_in(tmp_path, STILL)
    result = run_hydrofdi("report", sweep.directory, "--out", "out", cwd=tmp_path)
    assert "Warning" not in sweep.result.stderr + result.stderr
    assert "left out spectrum: P_1 does not vary" in result.stderr
    record = json.loads((tmp_path / "out" / "small.json").read_text())
    assert {row["verdict"] for row in record["rows"]} == {"still"}
    assert {value for row in record["rows"] for value in row["delta_fixed_percent"]} == {None}
    assert (
        "C1, C2, C3, C4, C5 and C6: open, at the configured phase."
        in (tmp_path / "out" / "small.md").read_text()
    )


def test_a_clipped_sensor_is_marked_and_its_constant_record_gives_no_change(tmp_path):
    text = SMALL.replace("sweep:", "pressure_1_sensor: {lowest: 0, highest: 1 MPa}\nsweep:")
    report = run_hydrofdi("report", sweep_in(tmp_path, text).directory, cwd=tmp_path)
    printed = " ".join(report.stdout.split())
    assert "clipped (R), 4 runs" in printed
    assert "in up to 100 % of the samples" in printed
    assert "not reproduced" not in printed
