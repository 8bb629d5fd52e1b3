"""What a file or a setting puts in place of the study that it extends."""

import pytest

from hydrofdi.config import load_experiment

PARENT = """\
name: parent
study:
  population:
    over: {friction.scale: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}
    per_record: {load.random_force: {uniform: [0 N, 100 N]}}
  healthy: {fit: 20, test: 10}
  faults: {leakage.internal_flow: {logspace: [0.1 L/min, 1 L/min, 3]}, each: 5}
  shifts: {rough: {friction.scale: {uniform: [1.5, 2]}}}
"""

NORMAL = pytest.approx([1.0, 0.05])


@pytest.fixture
def child(tmp_path):
    (tmp_path / "parent.yaml").write_text(PARENT)

    def load(study="{}", *settings):
        file = tmp_path / "child.yaml"
        file.write_text(f"name: child\nextends: parent.yaml\nstudy: {study}\n")
        return load_experiment(file, settings).study

    return load


def test_a_distribution_replaces_the_inherited_one(child):
    in_file = child("{population: {over: {friction.scale: {normal: ±5 %}}}}")
    set_later = child("{}", "study.population.over.friction.scale={normal: ±5 %}")
    for study in (in_file, set_later):
        assert study.population.over["friction.scale"] == {"normal": NORMAL}
        assert "supply.pressure" in study.population.over


def test_null_leaves_out_what_was_inherited(child):
    study = child("{shifts: null, population: {over: null}}")
    assert study.shifts == {}
    assert study.population.over == {}
