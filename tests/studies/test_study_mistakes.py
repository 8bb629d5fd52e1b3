"""Each mistake in a study is one sentence, at its place in the file."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.store.request import REQUEST_FILE, read_request

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


@pytest.mark.parametrize("width", ["±20", "±1e6", "+/- 20"])
def test_a_width_without_a_unit_is_a_mistake_that_suggests_one(tmp_path, width):
    (mistake,) = mistakes(tmp_path, over=f"fluid.bulk_modulus: {{uniform: {width}}}")
    number = width.removeprefix("±").removeprefix("+/-").strip()
    assert mistake.message == f"±{number} has no unit; write ±{number} % or ±{number} Pa"


def test_a_width_of_a_number_without_a_unit_stays_one(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY.format(over="friction.scale: {uniform: ±0.2}", levels="[1 L/min]"))
    assert load_experiment(file).study.population.over["friction.scale"] == {"uniform": [0.8, 1.2]}


def test_a_width_that_is_not_finite_is_a_mistake(tmp_path):
    (mistake,) = mistakes(tmp_path, over="fluid.bulk_modulus: {uniform: ±1e400 %}")
    assert "must be finite" in mistake.message


@pytest.mark.parametrize("kind", ["uniform", "triangular"])
def test_a_width_that_reaches_impossible_values_is_told_at_its_place(tmp_path, kind):
    (mistake,) = mistakes(tmp_path, over=f"fluid.bulk_modulus: {{{kind}: ±150 %}}")
    assert mistake.origin.endswith("study.yaml:3")
    assert "±150 % reaches an invalid value: must be greater than 0" in mistake.message


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("study=", "has no value"),
        ("sweep={grid: {study.population.seed: [1, 2]}}", "no parameter 'study.population.seed'"),
        ("baseline={leakage.internal_coefficient: 1e-9}", "a leaking baseline is not a healthy actuator"),
        ("study.population.over={friction.scale: {integerx: [1, 2]}}", "unknown distribution"),
        ("study.population.over={friction.scale: ±20 %}", "expected one of uniform"),
        ("study.population.over={friction.scale: {uniform: null}}", "expected [low, high]"),
        ('detection.scores={"a\\nb": {kind: lda, of: [dwt]}}', "is not a valid label of a score"),
        (
            "study.faults.over={leakage.internal_flow: [1 L/min], leakage.internal_coefficient: [1e-9]}",
            "give leakage.internal_flow or leakage.internal_coefficient, not both",
        ),
        ("indicators=[dtw]", "there is no indicator 'dtw'"),
        ("extends=nope.yaml", "unknown key"),
    ],
)
def test_one_mistake_is_one_line(tmp_path, setting, sentence):
    more = "detection: {indicators: [dwt, pressure_statistics]}\n"
    (mistake,) = mistakes(tmp_path, setting, more=more)
    assert sentence in mistake.message
    assert "\n" not in str(mistake)


def test_a_study_has_no_claims(tmp_path):
    assert any("a study has no claims" in str(each) for each in mistakes(tmp_path, "claims=[C1]"))


def test_a_file_that_is_extended_and_not_there_is_told_with_its_line(tmp_path):
    (mistake,) = mistakes(tmp_path, more="extends: nope.yaml\n")
    assert mistake.origin.endswith("study.yaml:6")
    assert mistake.message.endswith("nope.yaml: no such file")


def test_a_stored_request_that_is_cut_off_is_told_in_a_short_line(tmp_path):
    text = load_experiment().model_dump_json()
    (tmp_path / REQUEST_FILE).write_text(text[: len(text) // 2])
    with pytest.raises(StoreError, match="is not JSON") as error:
        read_request(tmp_path)
    assert len(str(error.value)) < len(str(tmp_path)) + 200
