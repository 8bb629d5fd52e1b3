"""Distributions about the experiment's own value, and of whole numbers."""

import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError

SAMPLE = "name: s\n{more}\nsweep:\n  sample:\n    count: {count}\n    over:\n      {over}\n"


def over(tmp_path, entry, *settings, more="", count=64):
    file = tmp_path / "s.yaml"
    file.write_text(SAMPLE.format(over=entry, more=more, count=count))
    return load_experiment(file, settings)


@pytest.mark.parametrize(
    ("entry", "arguments"),
    [
        ("supply.pressure: {uniform: ±5 %}", {"uniform": [0.95 * 17.2e6, 1.05 * 17.2e6]}),
        ("supply.pressure: {uniform: +/-0.2 MPa}", {"uniform": [17.0e6, 17.4e6]}),
        ("valve.lap: {uniform: ±1 µm}", {"uniform": [-1e-6, 1e-6]}),
        ("actuator.mass: {normal: ±2.4 %}", {"normal": [12.3, 0.024 * 12.3]}),
        ("friction.scale: {triangular: ±30 %}", {"triangular": [0.7, 1.0, 1.3]}),
        ("pressure_1_sensor.bias: {normal: ± 25 kPa}", {"normal": [0.0, 25e3]}),
    ],
)
def test_plus_or_minus_is_taken_about_the_nominal_value(tmp_path, entry, arguments):
    name = entry.partition(":")[0]
    ((kind, values),) = over(tmp_path, entry).sweep.sample.over[name].items()
    ((wanted_kind, wanted),) = arguments.items()
    if name == "actuator.mass":
        nominal = load_experiment().actuator.mass
        wanted = [nominal, 0.024 * nominal]
    assert (kind, values) == (wanted_kind, pytest.approx(wanted))


def test_the_nominal_value_is_that_of_the_file_and_of_settings(tmp_path):
    entry = "fluid.bulk_modulus: {uniform: ±10 %}"
    in_file = over(tmp_path, entry, more="fluid: {bulk_modulus: 600 MPa}")
    set_later = over(tmp_path, entry, "fluid.bulk_modulus=1 GPa", more="fluid: {bulk_modulus: 600 MPa}")
    ends = [each.sweep.sample.over["fluid.bulk_modulus"]["uniform"] for each in (in_file, set_later)]
    assert ends == [pytest.approx([540e6, 660e6]), pytest.approx([0.9e9, 1.1e9])]


def test_replicates_vary_about_the_nominal_value_too(tmp_path):
    experiment = load_experiment(
        settings=["replicates={count: 2, over: {friction.viscous: {uniform: ±10 %}}}"]
    )
    assert experiment.replicates.over["friction.viscous"] == {"uniform": pytest.approx([45.0, 55.0])}


def test_whole_numbers_are_drawn_with_both_ends(tmp_path):
    runs = expand_runs(over(tmp_path, "input.seed: {integers: [3, 6]}", more="input: {shape: steps}")).runs
    values = runs.values("input.seed")
    assert set(values) == {3, 4, 5, 6}
    assert all(type(value) is int for value in values)


@pytest.mark.parametrize(
    "entry",
    [
        "valve.lap: {uniform: ±20 %}", "supply.pressure: {uniform: ±0.2 mm}",
        "supply.pressure: {uniform: ±0 MPa}", "supply.pressure: {loguniform: ±5 %}",
        "friction.law: {uniform: ±5 %}",
        "leakage.internal_flow: {uniform: ±5 %}", "input.seed: {uniform: [0, 9]}",
        "supply.pressure: {integers: [1, 9]}", "input.seed: {integers: [9, 1]}",
        "supply.presure: {uniform: ±5 %}",
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(tmp_path, entry):
    with pytest.raises(ConfigError) as error:
        over(tmp_path, entry)
    (mistake,) = error.value.mistakes
    assert mistake.origin == f"{tmp_path / 's.yaml'}:7"
