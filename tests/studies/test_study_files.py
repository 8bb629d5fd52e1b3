"""What a file may say of a study, what it inherits, and the mistakes in it, each at its place."""

from pathlib import Path

import pytest
import yaml

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError

STUDY = """\
name: small
study:
  healthy: {fit: 20, test: 10}
  faults: {leakage.internal_flow: [0.1 L/min, 1 L/min], each: 5}
"""


@pytest.fixture
def loaded(tmp_path):
    def load(text=STUDY, *settings):
        file = tmp_path / "study.yaml"
        file.write_text(text)
        return load_experiment(file, settings)

    return load


def test_designs_do_not_vary_what_the_study_draws(loaded):
    with pytest.raises(ConfigError, match=r"measurement\.seed varies in both sweep and study"):
        loaded(STUDY + "  population: {per_record: {measurement.seed: {integers: [0, 9]}}}\n"
               "sweep: {grid: {measurement.seed: [1, 2]}}\n")  # fmt: skip


def test_records_that_are_drawn_alike_are_refused(loaded):
    text = STUDY + "  population: {per_record: {measurement.seed: {integers: [0, 1]}}}\n"
    with pytest.raises(ConfigError, match="twice"):
        expand_runs(loaded(text, "wavelet.phase=0"))


@pytest.mark.parametrize(
    ("more", "where"),
    [("shifts: {deep: {wavelet.levels: 12}}", "'shift deep', at "),
     ("confusions: {weak: {supply.return_pressure: 30 MPa}}", "'confusion weak', at ")],
)  # fmt: skip
def test_an_impossible_draw_names_its_population_and_what_makes_it_impossible(loaded, more, where):
    varied = "population: {over: {friction.viscous: {uniform: ±10 %}, supply.pressure: {uniform: ±5 %}}}"
    with pytest.raises(ConfigError) as error:
        expand_runs(loaded(f"{STUDY}  {varied}\n  {more}\n"))
    assert where in str(error.value)
    assert "\n" not in str(error.value)


MISTAKES = {
    "study.faults": [
        ("{leakage.internal_flow: [0 L/min], each: 5}", ""),
        ("{friction.viscous: [60], each: 5}", ""),
        ("{leakage.internal_flow: [1], leakage.internal_coefficient: [1e-9], each: 5}", ""),
        ("{leakage.internal_flow: [1, -1 L/min], each: 5}", ".over.leakage.internal_flow[1]"),
        ("{leakage.internal_flow: [1, null], each: 5}", ".over.leakage.internal_flow[1]"),
    ],
    "study.shifts.own": [
        ("3", ""),
        ("{fluid.bulk_moduls: 1}", ".fluid.bulk_moduls"),
        ("{fluid.bulk_modulus: +x %}", ".fluid.bulk_modulus"),
        ("{fluid.bulk_modulus: -100 %}", ".fluid.bulk_modulus"),
        ("{supply.return_pressure: +5 %}", ".supply.return_pressure"),
        ("{control.law: +5 %}", ".control.law"),
    ],
    "study.population": [
        ("{methode: random}", ".methode"),
        ("{over: {fluid.bulk_modulus: {uniform: ±1e400 %}}}", ".over.fluid.bulk_modulus.uniform"),
        ("{over: {fluid.bulk_modulus: {triangular: ±150 %}}}", ".over.fluid.bulk_modulus.triangular"),
        ("{over: {friction.scale: {integerx: [1, 2]}}}", ".over.friction.scale.integerx"),
        ("{over: {friction.scale: ±20 %}}", ".over.friction.scale"),
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
        ("{kind: mahalanobis, of: [dwt], shrinkage: 2}", ".shrinkage"),
    ],
    "detection.online": [
        (f"{{false_alarm_every: {every}, charts: {{a: {{of: weak_rls.leakage, chart: cusum}}}}}}", place)
        for every, place in (("0 h", ".false_alarm_every[0]"), ("[]", ".false_alarm_every"))
    ],
    "detection.online.charts.own": [
        ("{of: weak_rls.leakage, chart: cusm}", ".chart"),
        ("{of: weak_rls.leakage, chart: cusum, shift: -2}", ".shift"),
        ("{of: weak_rls.leakge, chart: cusum}", ".of"),
        ("{chart: cusum}", ".of"),
        ("{of: dwt.d3, chart: cusum}", ".of"),
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
def test_a_mistake_is_one_line_with_its_place(tmp_path, loaded, key, text, inside):
    with pytest.raises(ConfigError) as error:
        loaded(study(key, text))
    (mistake,) = error.value.mistakes
    assert (mistake.where, mistake.origin) == (f"{key}{inside}", f"{tmp_path / 'study.yaml'}:5")
    assert "\n" not in str(mistake)


def test_options_may_stand_beside_the_rule_and_one_time_is_a_list(loaded):
    charts = "charts: {a: {of: weak_rls.leakage, chart: cusum, shift: 3}}"
    online = loaded(study("detection.online", f"{{false_alarm_every: 2 h, {charts}}}")).detection.online
    assert online.false_alarm_every == [7200.0]
    assert online.charts["a"].options == {"shift": 3}


PARENT = (
    STUDY
    + """\
  population: {over: {friction.scale: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}
  shifts: {rough: {friction.scale: {uniform: [1.5, 2]}}}
"""
)


def test_a_distribution_replaces_the_inherited_one_and_null_leaves_it_out(loaded, tmp_path):
    (tmp_path / "parent.yaml").write_text(PARENT)

    def child(study, *settings):
        return loaded(f"name: child\nextends: parent.yaml\nstudy: {study}\n", *settings).study

    in_file = child("{population: {over: {friction.scale: {normal: ±5 %}}}}")
    set_later = child("{}", "study.population.over.friction.scale={normal: ±5 %}")
    for study in (in_file, set_later):
        assert study.population.over["friction.scale"] == {"normal": pytest.approx([1.0, 0.05])}
        assert "supply.pressure" in study.population.over
        assert "rough" in study.shifts
    bare = child("{shifts: null, population: {over: null}}")
    assert bare.shifts == bare.population.over == {}


TEMPLATES = Path(__file__).parents[2] / "configs" / "templates"


@pytest.mark.parametrize("template", ["actuator.yaml", "online.yaml"])
@pytest.mark.parametrize("own", ["551 MPa", "1.4 GPa"])
def test_the_stiffer_oil_of_a_template_is_stiffer_than_any_of_its_population(template, own, loaded):
    text = (TEMPLATES / template).read_text().replace("bulk_modulus: 551 MPa", f"bulk_modulus: {own}")
    assert own in yaml.safe_load(text)["fluid"]["bulk_modulus"]
    study = loaded(text).study
    _, highest = study.population.over["fluid.bulk_modulus"]["uniform"]
    assert study.shifts["stiffer"]["fluid.bulk_modulus"] > highest


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("fluid.bulk_modulus", "+25 %", 1.125e9), ("fluid.bulk_modulus", "-10%", 0.81e9),
        ("fluid.bulk_modulus", "−10 %", 0.81e9), ("fluid.bulk_modulus", "1 GPa", 1e9),
        ("friction.scale", "+25 %", 1.25),
    ],
)  # fmt: skip
def test_a_share_is_taken_of_the_own_value(loaded, name, value, expected):
    shifts = loaded(STUDY, "fluid.bulk_modulus=900 MPa", f"study.shifts.other.{name}={value}").study.shifts
    assert shifts["other"][name] == pytest.approx(expected, rel=1e-12)
