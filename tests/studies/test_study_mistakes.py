"""Each mistake in a study is one line at its place in the file."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

MISTAKES = {
    "study.faults": [
        ("{leakage.internal_flow: [0 L/min], each: 5}", ""),
        ("{friction.viscous: [60], each: 5}", ""),
        ("{each: 5}", ""),
        ("{leakage.internal_flow: [1], leakage.internal_coefficient: [1e-9], each: 5}", ""),
        ("{leakage.internal_flow: [1 mm], each: 5}", ".over.leakage.internal_flow[0]"),
        ("{leakage.internal_flow: [1, -1 L/min], each: 5}", ".over.leakage.internal_flow[1]"),
        ("{leakage.internal_flow: [1, null], each: 5}", ".over.leakage.internal_flow[1]"),
        ("{leakage.internal_flow: [1, [1]], each: 5}", ".over.leakage.internal_flow[1]"),
    ],
    "study.shifts.own": [
        ("3", ""),
        ("{fluid.bulk_moduls: 1}", ".fluid.bulk_moduls"),
        ("{fluid.bulk_modulus: +x %}", ".fluid.bulk_modulus"),
        ("{fluid.bulk_modulus: +0 %}", ".fluid.bulk_modulus"),
        ("{fluid.bulk_modulus: -100 %}", ".fluid.bulk_modulus"),
        ("{supply.return_pressure: +5 %}", ".supply.return_pressure"),
        ("{control.law: +5 %}", ".control.law"),
    ],
    "study.population": [
        ("{methode: random}", ".methode"),
        ("{over: {fluid.bulk_modulus: {uniform: ±20}}}", ".over.fluid.bulk_modulus.uniform"),
        ("{over: {fluid.bulk_modulus: {uniform: ±1e400 %}}}", ".over.fluid.bulk_modulus.uniform"),
        ("{over: {fluid.bulk_modulus: {triangular: ±150 %}}}", ".over.fluid.bulk_modulus.triangular"),
        ("{over: {friction.scale: {integerx: [1, 2]}}}", ".over.friction.scale.integerx"),
        ("{over: {friction.scale: ±20 %}}", ".over.friction.scale"),
        ("{over: {friction.scale: {uniform: null}}}", ".over.friction.scale.uniform"),
    ],
    "study.sensitivity": [("{alone: 10}", "")],
    "extends": [("nope.yaml", "")],
    "sweep": [("{grid: {study.population.seed: [1, 2]}}", ".grid.study.population.seed")],
    "baseline": [("{leakage.internal_coefficient: 1e-9}", ".leakage.internal_coefficient")],
    "detection.indicators": [("[modwt]", "[0]")],
    "detection.scores.dwt": [("{kind: lda, of: [dwt]}", "")],
    "detection.scores.s": [
        ("{kind: lda, of: [dwt.d9]}", ".of[0]"),
        ("{kind: ldaa, of: [dwt]}", ".kind"),
        ("{kind: compensated, of: [dwt.d1]}", ""),
        ("{kind: compensated, of: [dwt], by: [modwt.d1]}", ".by[0]"),
        ("{kind: lda, of: [dwt], by: [dwt.d1]}", ""),
        ("{kind: mahalanobis, of: [dwt], shrinkag: 0.1}", ".shrinkag"),
        ("{kind: mahalanobis, of: [dwt], shrinkage: 2}", ".shrinkage"),
    ],
    "detection.online.charts.own": [
        ("{of: weak_rls.leakage, chart: cusm}", ".chart"),
        ("{of: weak_rls.leakage, chart: cusum, shft: 2}", ".shft"),
        ("{of: weak_rls.leakage, chart: cusum, shift: -2}", ".shift"),
        ("{of: weak_rls.leakge, chart: cusum}", ".of"),
        ("{chart: cusum}", ".of"),
        ("{of: weak_rls.leakage}", ".chart"),
    ],
}


def study(key, text):
    """A study with a text under a key, at the end of the file."""
    lines = ["name: small", "indicators: {dwt: {}, weak_rls: {trace_duration: 20 s}}", "study:"]
    lines.append("  healthy: {fit: 20, test: 10}")
    room, *inner = key.split(".")
    if room == "study":
        room, inner = f"  {inner[0]}", inner[1:]
    for part in reversed(inner):
        text = f"{{{part}: {text}}}"
    return "\n".join([*lines, f"{room}: {text}"]) + "\n"


@pytest.mark.parametrize(
    ("key", "text", "inside"), [(key, *each) for key, own in MISTAKES.items() for each in own]
)
def test_a_mistake_is_one_line_with_its_place(tmp_path, key, text, inside):
    file = tmp_path / "study.yaml"
    file.write_text(study(key, text))
    with pytest.raises(ConfigError) as error:
        load_experiment(file)
    (mistake,) = error.value.mistakes
    assert (mistake.where, mistake.origin) == (f"{key}{inside}", f"{file}:5")
    assert "\n" not in str(mistake)


@pytest.mark.parametrize("every", ["0 h", "[1 h, 2 m]", "[]", "1 furlong"])
def test_mistaken_times_between_false_alarms_are_told(tmp_path, every):
    file = tmp_path / "study.yaml"
    charts = "charts: {a: {of: weak_rls.leakage, chart: cusum}}"
    file.write_text(study("detection.online", f"{{false_alarm_every: {every}, {charts}}}"))
    with pytest.raises(ConfigError, match=r":5: detection\.online\.false_alarm_every"):
        load_experiment(file)


def test_options_may_stand_beside_the_rule_and_one_time_is_a_list(tmp_path):
    file = tmp_path / "study.yaml"
    charts = "charts: {a: {of: weak_rls.leakage, chart: cusum, shift: 3}}"
    file.write_text(study("detection.online", f"{{false_alarm_every: 2 h, {charts}}}"))
    online = load_experiment(file).detection.online
    assert online.false_alarm_every == [7200.0]
    assert online.charts["a"].options == {"shift": 3}
