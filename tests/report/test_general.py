"""Experiments that are no paper's study: their reports speak of no paper."""

import csv
import io
import json
import re

import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.papers import make_report
from hydrofdi.report.figures import draw_figure
from tests.commands import run_hydrofdi
from tests.conftest import REPOSITORY, sweep_in

FRICTION = """\
name: friction
record: {duration: 2 s}
store: {signals: none}
leakage: {internal_coefficient: 1e-9}
sweep: {grid: {friction.viscous: [40, 60], input.period: [1 s, 2 s]}}
"""


@pytest.fixture(scope="module")
def friction(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("friction"), FRICTION)


@pytest.mark.parametrize("form", ["text", "markdown", "json", "csv"])
def test_a_sweep_of_friction_and_period_speaks_of_no_table_and_no_claim(friction, form):
    text = run_hydrofdi("report", friction.directory, "--format", form, cwd=friction.folder).stdout.lower()
    assert "friction.viscous" in text
    for word in ("table 3", "table3", "claim", "paper", "maddahi", "d3 rule", "published", "scenario"):
        assert word not in text.partition("configuration and provenance")[0], word


def test_its_page_and_files_speak_of_none_either(friction, tmp_path):
    assert run_hydrofdi("report", friction.directory, "--out", tmp_path, cwd=tmp_path).returncode == 0
    page = (tmp_path / "friction.html").read_text(encoding="utf-8").partition("section-provenance")[0]
    assert "Change of the details" in page
    assert "claim" not in page.lower()
    assert not list(tmp_path.glob("figure?.*"))


def test_it_has_nothing_to_check(friction):
    result = run_hydrofdi("report", friction.directory, "--check", cwd=friction.folder)
    assert result.returncode == 2
    assert "nothing to check" in result.stderr


def test_its_record_has_the_rows_of_all_runs(friction):
    record = json.loads(run_hydrofdi("report", friction.directory, "--json", cwd=friction.folder).stdout)
    assert len(record["rows"]) == friction.summary["planned"]
    assert all(len(row["delta_matched_percent"]) == 5 for row in record["rows"])
    assert "claims" not in record


def test_an_own_sweep_of_leakage_and_bulk_modulus_is_no_papers_study():
    own = {"sweep": {"grid": {"leakage.internal_flow": [0, 1e-5], "fluid.bulk_modulus": [7e8, 14e8]}}}
    assert load_experiment(own).paper is None
    assert load_experiment({"paper": "maddahi2015"} | own).paper


@pytest.mark.parametrize(
    ("listed", "line"),
    [("claims: [C1]", 2), ("reference:\n  cells: [{leakage: 0, bulk_modulus: 5e8, level: d1, delta: 1}]", 2)],
)
def test_claims_and_published_values_need_their_paper(tmp_path, listed, line):
    file = tmp_path / "own.yaml"
    file.write_text(f"name: own\n{listed}\n")
    with pytest.raises(ConfigError, match=rf"own.yaml:{line}: .*add 'paper: maddahi2015'"):
        load_experiment(file)
    file.write_text(f"name: own\npaper: maddahi2015\n{listed}\n")
    assert load_experiment(file).paper


OWN = """\
name: own
record: {duration: 1 s}
store: {signals: none}
indicators: [dwt, modwt]
fluid: {vapour_pressure: 12 kPa}
sweep: {grid: {leakage.internal_flow: [0.2 L/min], supply.pressure: [12 MPa, 15 MPa]}}
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("own"), OWN)


def test_full_shows_what_the_experiment_sets_and_where_the_rest_is(own):
    full = run_hydrofdi("report", own.directory, "--full").stdout
    _, settings = full.split("What the experiment sets")
    for key, value in (
        ("record.duration", "1 s"),
        ("fluid.vapour_pressure", "12 kPa"),
        ("indicators.modwt", "default options"),
        ("sweep.grid", "leakage.internal_flow: 0.2 L/min; supply.pressure: 12 MPa, 15 MPa"),
    ):
        assert re.search(rf"^{re.escape(key)} +{re.escape(value)}", settings, re.MULTILINE), key
    assert settings.count("\n") > 100


def test_the_page_folds_the_default_values_and_its_tables_take_the_keyboard(own, tmp_path):
    page = tmp_path / "own.html"
    assert run_hydrofdi("report", own.directory, "--html", page).returncode == 0
    text = page.read_text()
    (folded,) = re.findall(r"<details>(.*?)</details>", text, re.DOTALL)
    assert "12.3 kg" in folded
    assert "12 kPa" not in folded
    assert "12 kPa" in text
    tables = re.findall(r'<div class="table[^>]*>', text)
    assert len(tables) == text.count("<table")
    assert all('role="region"' in each and 'tabindex="0"' in each and "aria-label" in each for each in tables)


SEALED = """\
name: sealed
record: {duration: 2 s}
store: {signals: none}
indicators: [dwt, modwt]
sweep: {grid: {friction.viscous: [70 N·s/m, 50 N·s/m, 40 N·s/m]}}
"""
AGAINST_50 = SEALED + "baseline: {fluid.bulk_modulus: 551 MPa, friction.viscous: 50 N·s/m}\n"


def report_of(folder, text):
    return make_report(read_results(sweep_in(folder, text).directory))


def headers(report):
    tables = [table for block in report.document().blocks for table in block.shown_tables]
    return {column.heading for table in tables for column in table.shown}


def test_a_sealed_sweep_is_compared_with_the_fixed_baseline_only(tmp_path):
    report = report_of(tmp_path, AGAINST_50)
    assert report.analysis.baselines == ("fixed",)
    titles = [axis.get_title(loc="left") for axis in draw_figure(report, "sensitivity").axes]
    assert any("fixed" in title for title in titles)
    assert not any("matched" in title for title in titles)


def test_without_a_baseline_for_what_varies_there_is_no_table_of_zeros(tmp_path):
    report = report_of(tmp_path, SEALED)
    assert report.analysis.baselines == ()
    assert not [header for header in headers(report) if header.startswith("δ")]
    assert "sensitivity" not in report.document().figures
    assert report.usual_figure == "responses"
    with pytest.raises(ReportError, match="set a varied parameter in the baseline"):
        draw_figure(report, "sensitivity")


def test_rows_ascend_along_what_varies(tmp_path):
    table = report_of(tmp_path, AGAINST_50).analysis.table
    assert table.values("friction.viscous") == [40.0, 50.0, 70.0]


MEASURED = """\
name: measured
record: {duration: 6 s}
store: {signals: none}
pressure_1_sensor: {noise: 20 kPa}
indicators: {dwt: {}, statistics: {kind: pressure_statistics}, ring_down: {}}
replicates: {count: 3}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], friction.viscous: [40, 60]}}
"""


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("measured"), MEASURED)


def reported(measured, form):
    return run_hydrofdi("report", measured.directory, "--full", "--format", form, cwd=measured.folder).stdout


def test_numbers_and_changes_are_those_of_the_file(measured):
    data = read_results(measured.directory)
    means = data.columns["statistics.mean"]
    record = json.loads(reported(measured, "json"))
    lines = {line["run_id"]: line for line in csv.DictReader(io.StringIO(reported(measured, "csv")))}
    rows = {run_id: row for row, run_id in enumerate(data.columns["run_id"].astype(str))}
    assert len(record["rows"]) == 4
    for row in record["rows"]:
        place = rows[row["run_id"]]
        healthy = means[data.replicate_of == data.matched_baseline[place]].mean()
        change = 100.0 * (means[place] - healthy) / healthy
        assert row["indicators"]["statistics.mean"] == means[place]
        line = lines[row["run_id"]]
        assert float(line["statistics.mean [Pa]"]) == means[place]
        assert float(line["statistics.mean change_matched [%]"]) == pytest.approx(change)
        assert np.isfinite(change)


def test_without_the_indicator_of_the_details_there_is_no_table_of_them(tmp_path):
    text = MEASURED.replace("dwt: {}, ", "").replace("replicates: {count: 3}\n", "")
    text = text.replace("friction.viscous: [40, 60]", "fluid.bulk_modulus: [551 MPa, 689 MPa]")
    sweep = sweep_in(tmp_path, text)
    printed = run_hydrofdi("report", sweep.directory, "--full", cwd=tmp_path).stdout
    printed, _, _ = printed.partition("Configuration and provenance")
    assert "statistics (pressure_statistics)" in printed
    for words in ("details", "Table 3", "Claims"):
        assert words not in printed


def test_null_takes_the_paper_away(tmp_path):
    file = tmp_path / "own.yaml"
    base = REPOSITORY / "configs" / "table3.yaml"
    file.write_text(f"extends: {base}\nname: own\npaper: null\nclaims: []\n")
    assert not load_experiment(file).paper
