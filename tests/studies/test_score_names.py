"""What the scores of a study are made of is checked before anything runs."""

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


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("calm: {kind: compensated, of: [dwt]}", "calm"),
        ("calm: {kind: compensated, of: [dwt], by: [ring_down.frequency]}", "calm.by"),
        ("leak: {kind: lda, of: [dwt], by: [dwt.d1]}", "leak"),
        ("leak: {kind: lda, of: [pressure_statistic.mean]}", "leak.of"),
        ("leak: {kind: lda, of: [post_step_ac.rms, post_step_ac.rms_error]}", "leak.of"),
        ("leak: {kind: ldaa, of: [dwt]}", "leak"),
        ("far: {kind: mahalanobis, of: [dwt], shrinkag: 0.1}", "far.shrinkag"),
        ("far: {kind: mahalanobis, of: [dwt], shrinkage: 2}", "far.shrinkage"),
        ("far: {kind: lda, of: [dwt], shrinkage: 1}", "far.shrinkage"),
        ("far leak: {kind: lda, of: [dwt]}", "far leak"),
    ],
)
def test_a_score_that_cannot_be_made_is_a_mistake_with_its_line(line, key, tmp_path):
    (message,) = mistakes(tmp_path, line).splitlines()
    assert f"study.yaml:8: detection.scores.{key}" in message
