"""What the scores of a study are made of is checked before anything runs."""

import re

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

STUDY = """\
indicators: [dwt, pressure_statistics, post_step_ac]
study:
  healthy: {fit: 12, test: 4}
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}}}
detection:
  scores:
    sound: {kind: lda, of: [dwt, pressure_statistics.mean, "dwt.d3 (change)"]}
"""


def mistakes(folder, *lines):
    file = folder / "study.yaml"
    file.write_text(STUDY + "".join(f"    {line}\n" for line in lines))
    with pytest.raises(ConfigError) as error:
        load_experiment(file)
    return str(error.value)


def test_names_of_indicators_and_of_their_numbers_are_known(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY)
    assert load_experiment(file).detection.scores["sound"].kind == "lda"


def test_each_name_that_no_indicator_gives_is_a_mistake_with_its_line(tmp_path):
    said = mistakes(
        tmp_path,
        "leak: {kind: lda, of: [pressure_statistic.mean]}",
        "calm: {kind: compensated, of: [dwt], by: [ring_down.frequency]}",
        "unsure: {kind: lda, of: [post_step_ac.rms, post_step_ac.rms_error]}",
    ).splitlines()
    assert len(said) == 3
    assert re.search(
        r"study\.yaml:8: .*'pressure_statistic\.mean'; did you mean 'pressure_statistics", said[0]
    )
    assert re.search(r"study\.yaml:9: detection\.scores\.calm\.by.*'ring_down\.frequency'", said[1])
    assert re.search(r"study\.yaml:10: .*'post_step_ac\.rms_error'", said[2])


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("calm: {kind: compensated, of: [dwt]}", "needs 'by'"),
        ("leak: {kind: lda, of: [dwt], by: [dwt.d1]}", "no use for 'by'"),
        ("leak: {kind: ldaa, of: [dwt]}", "ldaa"),
        ("far: {kind: mahalanobis, of: [dwt], shrinkag: 0.1}", "far.shrinkag: unknown key; did you mean"),
        ("far: {kind: mahalanobis, of: [dwt], shrinkage: 2}", "far.shrinkage: must be at most 1; found 2"),
        ("far: {kind: lda, of: [dwt], shrinkage: 1}", "far.shrinkage: unknown key"),
        ("far leak: {kind: lda, of: [dwt]}", "not a valid label of a score (letters, digits, '_' and '-'"),
    ],
)
def test_a_score_that_cannot_be_made_is_a_mistake_with_its_line(line, said, tmp_path):
    message = mistakes(tmp_path, line)
    assert "study.yaml:8" in message
    assert said in message


def test_options_of_a_kind_stand_beside_it_and_are_kept(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY + "    far: {kind: mahalanobis, of: [dwt], shrinkage: 0.25}\n")
    short = load_experiment(file).detection
    assert short.scores["far"].options == {"shrinkage": 0.25}
    file.write_text(STUDY + "    far: {kind: mahalanobis, of: [dwt], options: {shrinkage: 0.25}}\n")
    assert load_experiment(file).detection == short
