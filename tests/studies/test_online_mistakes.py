"""Each mistake in what charts are asked is one sentence, at its place in the file."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

STUDY = """\
name: small
study:
  healthy: {{fit: 20, test: 10}}
  faults: {{leakage.internal_flow: [1 L/min], each: 5}}
indicators:
  weak_rls: {{trace_duration: {traced}}}
detection:
  online:
    {online}
"""


def loaded(tmp_path, online, traced="20 s"):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY.format(online=online.replace("\n", "\n    "), traced=traced))
    return load_experiment(file)


def mistakes(tmp_path, online, **more):
    with pytest.raises(ConfigError) as error:
        loaded(tmp_path, online, **more)
    return error.value.mistakes


@pytest.mark.parametrize(
    ("chart", "key"),
    [
        ("{of: weak_rls.leakage, chart: cusm}", "chart"),
        ("{of: weak_rls.leakage, chart: cusum, shft: 2}", "shft"),
        ("{of: weak_rls.leakage, chart: cusum, shift: -2}", "shift"),
        ("{of: weak_rls.leakge, chart: cusum}", "of"),
        ("{of: weak_rls.bulk_modulus, chart: cusum}", "of"),
        ("{chart: cusum}", "of"),
        ("{of: weak_rls.leakage}", "chart"),
    ],
)
def test_a_mistaken_chart_is_told_at_its_place(tmp_path, chart, key):
    (mistake,) = mistakes(tmp_path, f"charts:\n  fast: {chart}")
    assert mistake.where == f"detection.online.charts.fast.{key}"
    assert mistake.origin.endswith("study.yaml:10")


@pytest.mark.parametrize(
    ("every", "key"), [("0 h", "[0]"), ("[1 h, 2 m]", "[1]"), ("[]", ""), ("1 furlong", "[0]")]
)
def test_mistaken_times_between_false_alarms_are_told(tmp_path, every, key):
    charts = "charts: {a: {of: weak_rls.leakage, chart: cusum}}"
    (mistake,) = mistakes(tmp_path, f"false_alarm_every: {every}\n{charts}")
    assert mistake.where == f"detection.online.false_alarm_every{key}"


def test_options_may_stand_beside_the_rule_and_one_time_is_a_list(tmp_path):
    charts = "charts: {a: {of: weak_rls.leakage, chart: cusum, shift: 3}}"
    online = loaded(tmp_path, f"false_alarm_every: 2 h\n{charts}").detection.online
    assert online.false_alarm_every == [7200.0]
    assert online.charts["a"].options == {"shift": 3}
