"""Each mistake in a study is one sentence, at its place in the file."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

STUDY = """\
name: small
study:
  population: {{over: {{{over}}}}}
  healthy: {{fit: 20, test: 10}}
  faults: {{leakage.internal_flow: {levels}, each: 5}}
"""


def mistakes(tmp_path, *settings, over="", levels="[0.1 L/min, 1 L/min]", more=""):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY.format(over=over, levels=levels) + more)
    with pytest.raises(ConfigError) as error:
        load_experiment(file, settings)
    return error.value.mistakes


@pytest.mark.parametrize("level", ["0.1 L/mn", "-1 L/min", "foo", "null", "[1]"])
def test_a_mistaken_level_is_told_at_its_place(tmp_path, level):
    (mistake,) = mistakes(tmp_path, levels=f"[{level}, 1 L/min]")
    assert mistake.where == "study.faults.over.leakage.internal_flow[0]"
    assert mistake.origin.endswith("study.yaml:5")


@pytest.mark.parametrize(
    "setting",
    [
        "study=",
        "sweep={grid: {study.population.seed: [1, 2]}}",
        "baseline={leakage.internal_coefficient: 1e-9}",
        "study.population.over={friction.scale: {integerx: [1, 2]}}",
        "study.population.over={friction.scale: ±20 %}",
        "study.population.over={friction.scale: {uniform: null}}",
        'detection.scores={"a\\nb": {kind: lda, of: [dwt]}}',
        "study.faults.over={leakage.internal_flow: [1 L/min], leakage.internal_coefficient: [1e-9]}",
        "indicators=[dtw]",
        "extends=nope.yaml",
    ],
)
def test_one_mistake_is_one_line(tmp_path, setting):
    more = "detection: {indicators: [dwt, pressure_statistics]}\n"
    (mistake,) = mistakes(tmp_path, setting, more=more)
    assert "\n" not in str(mistake)


def test_a_file_that_is_extended_and_not_there_is_told_with_its_line(tmp_path):
    (mistake,) = mistakes(tmp_path, more="extends: nope.yaml\n")
    assert mistake.origin.endswith("study.yaml:6")
    assert mistake.message.endswith("nope.yaml: no such file")


@pytest.mark.parametrize(
    "width", ["uniform: ±20", "uniform: +/- 20", "uniform: ±1e400 %", "uniform: ±150 %", "triangular: ±150 %"]
)
def test_a_width_that_means_nothing_is_told_at_its_place(tmp_path, width):
    (mistake,) = mistakes(tmp_path, over=f"fluid.bulk_modulus: {{{width}}}")
    assert mistake.origin.endswith("study.yaml:3")
