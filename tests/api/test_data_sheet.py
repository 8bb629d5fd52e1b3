"""From a data sheet to a file that runs: numbers by hand, errors, ready machines, and plausibility."""

import math
import shlex
from itertools import pairwise

import numpy as np
import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.config.data_sheet import CylinderSheet, sheet_text
from hydrofdi.config.plausibility import idle_parameters, unusual_values
from hydrofdi.config.values import quantiles
from hydrofdi.errors import ConfigError
from hydrofdi.physics.hydraulic_mode import steady_speed
from hydrofdi.records.data_sheet import StatedMachine
from hydrofdi.settings.files import Source, parse_yaml, ready_folder, ready_names, validated
from tests.commands import run, run_json

PRESS = {
    "bore": "50 mm", "rod": "28 mm", "stroke": "400 mm", "supply": "210 bar",
    "valve": "40 L/min at 70 bar", "mass": "250 kg", "oil": "HLP46", "hose": "2 m x 12 mm",
}  # fmt: skip


def written(folder, **sheet):
    """The experiment of a data sheet."""
    return load_experiment(hydrofdi.init("press", folder=folder, **(PRESS | sheet)))


def test_the_numbers_of_the_file_are_those_by_hand(tmp_path):
    made = written(tmp_path)
    actuator, valve = made.actuator, made.valve
    volumes = actuator.chamber_volume, actuator.chamber_volume_2
    bore, annulus = math.pi / 4 * 0.05**2, math.pi / 4 * (0.05**2 - 0.028**2)
    hose = math.pi / 4 * 0.012**2 * 2.0
    assert actuator.areas == pytest.approx((bore, annulus), rel=1e-3)
    assert volumes == pytest.approx([0.22 * area + hose for area in (bore, annulus)], rel=1e-3)
    flow = valve.flow_gain * valve.area_gradient * 10.0 * valve.spool_gain * math.sqrt(35e5)
    assert flow == pytest.approx(40e-3 / 60.0, rel=1e-3)
    share = 2.0 * hose / sum(volumes)
    oil = 1.0 / (1.0 / made.fluid.bulk_modulus - share / 400e6) * (1.0 - share)
    assert 1.4e9 < oil < 2.0e9
    assert made.fluid.temperature == 318.15
    force = made.load.constant_force + made.load.random_force
    assert force == pytest.approx(0.3 * 210e5 * annulus, rel=0.01)
    assert 4.0 * made.control.amplitude == pytest.approx(0.4)
    # The slower direction crosses half of the stroke within a period, with time left to settle.
    gain = 40e-3 / 60.0 / math.sqrt(35e5)
    slow = steady_speed(210e5, 0.0, annulus, bore, gain, gain, 0.0)
    assert 0.2 / slow < made.input.period < 0.2 / slow + 1.0
    stiffness = made.fluid.bulk_modulus * sum(
        area**2 / volume for area, volume in zip(actuator.areas, volumes, strict=True)
    )
    crossover = made.control.proportional_gain * 0.0723
    assert crossover == pytest.approx(0.05 * math.sqrt(stiffness / 250.0), rel=0.02)


def test_what_is_known_replaces_the_guesses(tmp_path):
    known = {
        "null_leakage": "0.4 L/min", "return_pressure": "1 bar to 3 bar", "spring": "20 kN/m",
        "dead_volume": "50 cm³", "measured_modulus": "1.1 GPa", "valve": "40 L/min at 35 bar per edge",
    }  # fmt: skip
    made, area = written(tmp_path, **known), math.pi / 4 * 0.05**2
    hose = math.pi / 4 * 0.012**2 * 2.0
    assert made.actuator.chamber_volume == pytest.approx(0.2 * area + 50e-6 + hose, rel=1e-3)
    assert (made.fluid.bulk_modulus, made.actuator.load_stiffness) == pytest.approx((1.1e9, 20e3))
    flow = made.valve.flow_gain * made.valve.area_gradient * 10.0 * made.valve.spool_gain * math.sqrt(35e5)
    assert flow == pytest.approx(40e-3 / 60.0, rel=1e-3)
    largest = 0.4e-3 / 60.0 / (210e5 - 2e5)
    population = made.study.population.over
    ends = np.array([0.0, 1.0])
    assert quantiles(population["valve.lap_leakage"], ends) == pytest.approx(
        [0.1 * largest, largest], rel=5e-3
    )
    assert quantiles(population["supply.return_pressure"], ends) == pytest.approx([1e5, 3e5])
    balance = made.indicator_choice.made(made.wavelet)["flow_balance"].options
    assert balance.largest_clearance == pytest.approx(largest, rel=1e-3)


def test_a_description_takes_the_numbers_of_the_file_and_how_wrong_they_may_be(tmp_path):
    sheet = PRESS | {"null_leakage": "0.4 L/min"}
    made = written(tmp_path, **sheet)
    text = hydrofdi.init("sheet", template="description", folder=tmp_path, **sheet).read_text()
    stated = validated(StatedMachine, Source(parse_yaml(text, "").data["actuator"])).given
    own = made.indicator_choice.made(made.wavelet)["flow_balance"].options
    taken = {name: getattr(own, name) for name in ("error", "pressure_bias", "null_leakage", "piston_area_2")}
    assert {name: stated[name] for name in taken} == pytest.approx(taken, rel=1e-3)


def test_two_rods_mounting_and_oil_change_what_they_should(tmp_path):
    double = written(tmp_path, double_rod=True)
    assert double.actuator.piston_area_2 is None
    assert double.actuator.piston_area == pytest.approx(math.pi / 4 * (0.05**2 - 0.028**2), rel=1e-3)
    (tmp_path / "press.yaml").unlink()
    hanging = written(tmp_path, mounting="vertical-rod-down", oil="HLP22", hose="")
    assert hanging.actuator.weight == pytest.approx(-250.0 * 9.80665)
    assert hanging.load.constant_force == 0.0
    assert hanging.fluid.bulk_modulus > 2.0 * double.fluid.bulk_modulus


def test_the_command_writes_the_file_of_the_function_which_is_planned_without_a_doubt(tmp_path):
    sheet = PRESS | {"mounting": "vertical-rod-up"}
    options = [part for key, value in sheet.items() for part in (f"--{key}", value)]
    run("init", "press", *options, cwd=tmp_path, check=0)
    assert (tmp_path / "press.yaml").read_text() == sheet_text("press", sheet)
    plan = run_json("plan", "press.yaml", cwd=tmp_path)
    assert plan["planned"] == 1460
    made = load_experiment(tmp_path / "press.yaml")
    assert not unusual_values(made) + idle_parameters(made)
    assert not [each for each in plan["warnings"] if "study" in each or "machine" in each]


@pytest.mark.parametrize(("wrong", "key"), [
    ({"oil": "HLP47"}, "oil"), ({"valve": "40 L/min"}, "valve"), ({"valve": "40 bar at 70 bar"}, "valve"),
    ({"valve": "40 L/min at 700 bar"}, "valve"),
    ({"hose": "2 m"}, "hose"), ({"rod": "60 mm"}, "rod"), ({"mass": None}, "mass"),
    ({"bore": "50"}, "bore"), ({"mounting": "upside-down"}, "mounting"), ({"boor": "50 mm"}, "boor"),
])  # fmt: skip
def test_a_wrong_number_names_its_key_and_writes_nothing(wrong, key, tmp_path):
    sheet = {name: value for name, value in (PRESS | wrong).items() if value is not None}
    with pytest.raises(ConfigError, match=rf"(?m)^{key}: "):
        hydrofdi.init("press", folder=tmp_path, **sheet)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", [name for name in ready_names() if name.startswith("machines/")])
def test_a_ready_machine_is_what_its_own_command_writes(name):
    text = (ready_folder() / f"{name}.yaml").read_text()
    head, _, body = text.partition("\n\n")
    assert head.count("\n") >= 3
    command = body.partition("#   hydrofdi init ")[2].partition("\n#\n")[0].replace("\\\n#", "")
    stated, *words = shlex.split(command)
    given = dict.fromkeys((word[2:].replace("-", "_") for word in words if word.startswith("--")), True)
    for key, word in pairwise(words):
        if not word.startswith("--"):
            given[key[2:].replace("-", "_")] = word
    given = {key: value for key, value in given.items() if key in CylinderSheet.model_fields}
    assert stated == name.removeprefix("machines/")
    assert body == sheet_text(stated, given)


def test_the_table_names_what_is_unusual_causes_first(tmp_path):
    def of_sheet(sheet, **record):
        """A machine with one record, on which the same options act as in a population."""
        file = hydrofdi.init("press", folder=tmp_path, **sheet)
        made = load_experiment(file).model_dump(exclude_defaults=True)
        file.unlink()
        made.pop("study")
        made["actuator"].setdefault("inclination", 1e-30)
        made["fluid"]["temperature_rise"] = 0.01
        made["valve"] |= {"hysteresis": 1e-4, "null_offset": 1e-9}
        return made | {"record": record}

    def outside(made, **settings):
        found = hydrofdi.check(made, **settings).plausibility
        return [each["quantity"].partition(" ")[0] for each in found if each["change"]]

    slender = of_sheet(dict(PRESS, stroke="4 m", valve="40 L/min at 7 bar"), duration=1.0)
    assert outside(slender)[:2] == ["stroke", "largest"]
    made = of_sheet(PRESS, duration=4.0, sampling_frequency=500.0)
    for settings, first in (
        ({}, []), ({"random_force": 0.0, "constant_force": "0.1 N"}, ["load"]),
        ({"area_gradient": made["valve"]["area_gradient"] / 4.0}, ["valve"]),
        ({"viscous": 0.0}, ["hydraulic"]),
        ({"inclination": "-90 deg", "mass": "2 t"}, ["time"]),
    ):  # fmt: skip
        assert outside(made, **settings) == first
    for settings, first in (
        ({"area_gradient": "1 mm"}, ["valve"]), ({"constant_force": "-60 kN"}, ["load"]),
        ({"bulk_modulus": made["fluid"]["bulk_modulus"] / 10.0}, ["fluid.bulk_modulus"]),
        ({"mass": "400 t", "step": "0.1 ms"}, ["actuator.mass", "natural"]),
    ):  # fmt: skip
        assert outside(made, **settings)[: len(first)] == first
