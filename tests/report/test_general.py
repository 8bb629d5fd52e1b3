"""Experiments that are no paper's study: their reports speak of no paper."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.indicators import make_indicators
from hydrofdi.papers import make_report
from hydrofdi.report.figures import KINDS, draw_figure
from hydrofdi.report.indicators import measured_indicator, relative_change
from hydrofdi.report.page import render_json, render_page, write_all_forms
from hydrofdi.store.results import read_results
from hydrofdi.tables.table import Table
from tests.commands import run
from tests.conftest import sweep_in
from tests.report.rows import check_golden

FRICTION = """\
name: friction
record: {duration: 2 s}
store: {signals: none}
leakage: {internal_coefficient: 1e-9}
sweep: {grid: {friction.viscous: [40, 60], input.period: [1 s, 2 s]}}
"""


def test_claims_need_their_paper(tmp_path):
    file = tmp_path / "own.yaml"
    file.write_text("name: own\nclaims: [C1]\n")
    with pytest.raises(ConfigError, match=r"own.yaml:2: .*add 'paper: maddahi2015'"):
        load_experiment(file)
    file.write_text("name: own\npaper: maddahi2015\nclaims: [C1]\n")
    assert load_experiment(file).paper
    file.write_text("extends: table3\nname: own\npaper: null\nclaims: []\n")
    assert not load_experiment(file).paper


SEALED = """\
name: sealed
record: {duration: 2 s}
store: {signals: none}
indicators: [dwt, modwt]
sweep: {grid: {friction.viscous: [70 N·s/m, 50 N·s/m, 40 N·s/m]}}
"""


def test_a_sealed_sweep_is_compared_with_the_fixed_baseline_if_there_is_one_for_what_varies(tmp_path):
    def report_of(text):
        folder = tmp_path / str(len(text))
        folder.mkdir()
        return make_report(read_results(sweep_in(folder, text).directory))

    against = report_of(SEALED + "baseline: {fluid.bulk_modulus: 551 MPa, friction.viscous: 50 N·s/m}\n")
    assert against.baselines == ("fixed",)
    assert against.table.values("friction.viscous") == [40.0, 50.0, 70.0]
    report = report_of(SEALED)
    assert report.baselines == ()
    tables = [table for block in report.document().blocks for table in block.shown_tables]
    headers = {column.heading for table in tables for column in table.shown}
    assert not [header for header in headers if header.startswith("δ")], "no table of zeros"
    assert "sensitivity" not in report.document().figures
    with pytest.raises(ReportError):
        draw_figure(report, "sensitivity")


def test_a_report_keeps_its_tables_for_programs_and_its_page(made_up):
    """Less the configuration, which grows with every parameter, and what looks like its neighbour."""
    report = make_report(made_up)
    text = Table.of(report.columns()).to_csv()
    check_golden("made_up.csv", text)
    record = json.loads(render_json(report))
    lines = list(csv.DictReader(text.splitlines()))
    for row in record["rows"]:
        levels = [line for line in lines if line["run_id"] == row["run_id"]]
        for key in {key for key in row.keys() & levels[0].keys() if not key.startswith("largest")}:
            values = row.pop(key)
            texts = ["" if value is None else str(value) for value in np.broadcast_to(values, 5).tolist()]
            assert [line[key] for line in levels] == texts, key
    kept = {"rows": record["rows"][1::2], "claims": record["claims"][::2]}
    check_golden("made_up.txt", record | kept)
    document = report.document()
    blocks = tuple(block for block in document.blocks if block.key not in ("provenance", "settled"))
    page = render_page(replace(document, blocks=blocks), {}, {})
    check_golden("made_up.html", page[page.index("<main>") : page.index("</main>")] + "\n")


def test_the_same_data_give_the_same_bytes_in_all_forms(tmp_path):
    friction = sweep_in(tmp_path, FRICTION)
    run("report", friction.directory, "--check", check=2)  # a sweep without claims has nothing to check
    report = make_report(read_results(friction.directory))
    made = []
    for name in ("first", "second"):
        list(write_all_forms(report, tmp_path / name))
        made.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    forms = {f"friction.{suffix}" for suffix in ("md", "csv", "json", "html")}
    figures = {f"{name}.{kind}" for name in ("sensitivity", "responses") for kind in KINDS}
    assert made[0].keys() - {"friction.parquet"} == forms | figures
    assert made[0] == made[1]


def test_text_is_no_formula_in_a_spreadsheet():
    cells = ["=1+1", "+a", "-b", "@c", "\td", "e=1", -1.5, None]
    lines = Table.of({"label": cells}).to_csv().splitlines()
    assert lines == ["label", "'=1+1", "'+a", "'-b", "'@c", "'\td", "e=1", "-1.5", '""']


def with_ring(data, frequencies):
    """The data and the lines of a report with an indicator that is measured of the first four runs."""
    (indicator,) = make_indicators({"ring": {"kind": "ring_down"}}).values()
    damping = np.where(np.isnan(frequencies), np.nan, 0.02)
    columns = {f"ring.{output.name}": damping for output in indicator.outputs}
    columns["ring.frequency"] = np.array(frequencies)
    study = measured_indicator("ring", indicator, replace(data, columns=data.columns | columns))
    made = make_report(data)
    vars(made)["indicators"] = (study,)
    lines = csv.DictReader(Table.of(made.columns()).to_csv().splitlines())
    return json.loads(json.dumps(made.record(), allow_nan=False)), {line["run_id"]: line for line in lines}


def test_indicators_stand_in_the_data_of_runs_with_the_reason_of_a_hole(made_up):
    record, by_run = with_ring(made_up, [60.0, 66.0, 59.4, 66.0, np.nan, np.nan])
    assert {row["indicators"]["ring.frequency"] for row in record["rows"]} == {60.0, 66.0, 59.4, None}
    assert record["indicators"][0]["not_measured"][1]["why"] == "diverged"
    assert by_run[f"{1:016x}"]["ring.frequency [Hz]"] == "66.0"
    assert float(by_run[f"{1:016x}"]["ring.frequency change_fixed [%]"]) == pytest.approx(10.0)
    assert float(by_run[f"{2:016x}"]["ring.frequency change_matched [%]"]) == pytest.approx(-1.0)
    assert by_run[f"{5:016x}"]["ring.frequency [Hz]"] == ""
    _, by_run = with_ring(made_up, [1e-7, 66.0, 5.0, 66.0, np.nan, np.nan])
    line = next(each for each in by_run.values() if each["ring.frequency [Hz]"] == "5.0")
    assert line["ring.frequency change_fixed [%]"] == "", "near zero, changes stand in the own unit"
    assert float(line["ring.frequency change_fixed [Hz]"]) == pytest.approx(5.0)


def test_a_change_is_relative_to_the_size_of_the_healthy_value():
    values = np.array([-2.0, -1.0, 0.0, 3.0])
    np.testing.assert_allclose(relative_change(np.full(4, -2.0), values), [0.0, 50.0, 100.0, 250.0])
    assert np.isnan(relative_change(np.zeros(4), values)).all(), "nothing is relative to zero"
