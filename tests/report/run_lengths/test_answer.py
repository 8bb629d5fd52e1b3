"""The tables of a study of delays."""

import csv
import io
from dataclasses import replace
from pathlib import Path

import pytest

from hydrofdi.detectors.rules import Rules
from hydrofdi.report.detection.sections import run_lengths_block
from hydrofdi.studies.records import Detection
from tests.commands import run, run_json
from tests.studies.test_run_lengths import EVERY, LARGE, judged, traces


def block(every):
    of = traces()
    charts = [*judged(of, every)]
    charts += [replace(chart, label="sums") for chart in judged(of, every, chart="cusum", shift=4)]
    return run_lengths_block(Detection(of.records, (), Rules(), charts=tuple(charts)))


def test_delays_have_their_interval_and_a_chart_without_a_limit_its_reason():
    found = block([EVERY, 1e6])
    delays, alarms, refused = found.tables
    (own,) = [row for row in delays if (row["chart"], row["population"]) == ("own", LARGE.name)]
    assert [own[f"delay_median{end}_s"] for end in ("", "_low", "_high")] == [1.5] * 3
    assert alarms["false_alarm_every_h"] == pytest.approx(EVERY / 3600.0)
    assert {(row["chart"], round(row["false_alarm_every_h"])) for row in refused} == {
        ("own", 278),
        ("sums", 278),
    }
    assert found.figures
    assert not block(1e6).figures


FEWER = ("--set", "study.healthy={fit: 40, test: 24, shift: 5}", "--set", "study.faults.each=8")
SMOKE = Path(__file__).parents[3] / "configs" / "delays" / "smoke.yaml"


def test_every_chart_limit_and_population_has_a_line_whose_level_is_the_flow_after_the_onset(tmp_path):
    run("sweep", SMOKE, *FEWER, "--out", tmp_path / "out", "--engine", "in-process", check=0)
    record = run_json("report", tmp_path / "out")
    for each in record["run_lengths"]:
        small, large = each["delays"]
        assert (small["leakage_L_per_min"], large["leakage_L_per_min"]) == pytest.approx((0.05, 0.5))
        for delay in (small, large):
            true = delay["true_mean_flow_after_onset_L_per_min"]
            assert true == pytest.approx(delay["leakage_L_per_min"], rel=0.25)
        assert large["n"] == 8
        assert large["found"] > 4
        assert 0.0 < large["delay_median_s"] < 1.5
    table = csv.DictReader(io.StringIO(run("report", tmp_path / "out", "--format", "csv", check=0).stdout))
    lines = [line for line in table if line["chart"]]
    assert len(lines) == 4 * 4
    medians = [each["delays"][1]["delay_median_s"] for each in record["run_lengths"]]
    found = [line["delay_median_s"] for line in lines if line["population"] == "0.5 L/min"]
    assert [*map(float, found)] == medians


def test_a_chart_on_sensors_that_a_machine_lacks_is_left_out(tmp_path):
    small = ["--set", "study.healthy={fit: 5, test: 5, shift: 5}", "--set", "study.faults.each=1"]
    sensors = ["--set", "detection.sensors=[P1]"]
    run("sweep", SMOKE, *small, *sensors, "--out", tmp_path / "out", "--engine", "in-process", check=0)
    shown = run_json("report", tmp_path / "out")
    assert shown["run_lengths"] == []
    assert any("weak_rls is left out" in remark for remark in shown["studies"][0]["remarks"])


def test_a_mistaken_chart_ends_the_command_with_its_line(tmp_path):
    file = tmp_path / "mistaken.yaml"
    charts = "{online: {charts: {a: {of: dwt.d3, chart: cusum}}}}"
    file.write_text(f"extends: {SMOKE}\nname: mistaken\ndetection: {charts}\n")
    done = run("sweep", file, check=2)
    assert f"{file}:3: detection.online.charts.a.of: no indicator keeps a trace of 'dwt.d3'" in done.stderr
