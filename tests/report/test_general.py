"""Experiments that are no paper's study: their reports speak of no paper."""

import json

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

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
