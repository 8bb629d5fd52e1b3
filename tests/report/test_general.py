"""Experiments that are no paper's study: their reports speak of no paper."""

import json

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.papers.maddahi2015 import is_study
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


@pytest.mark.parametrize("form", ["text", "markdown", "latex", "json", "csv"])
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


@pytest.mark.parametrize(
    ("config", "expected"),
    [
        ("table3", True),
        ("scenarios", True),
        ("mode-shift", True),
        ("dry-friction", False),
        ("sensor-noise", False),
    ],
)
def test_the_ready_studies_of_the_paper_are_recognised(config, expected):
    assert is_study(load_experiment(REPOSITORY / "configs" / f"{config}.yaml")) is expected
