"""Warnings of parameters that are stated but have no effect: their option is off."""
# ruff: noqa: E501

from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.plausibility import RULES, idle_parameters
from hydrofdi.config.request import parameter_names

CONFIGS = sorted((Path(__file__).parents[2] / "configs").glob("*.yaml"))
AIR = "fluid.free_air has no effect: fluid.law is constant in every run"


def idle(*settings):
    return idle_parameters(load_experiment(settings=settings))


def test_simulate_warns_and_goes_on(hydrofdi):
    result = hydrofdi("simulate", "--set", "record.duration=2 s", "--set", "fluid.free_air=0.05")
    assert (result.returncode, result.stderr.splitlines()[0]) == (0, f"warning: {AIR}")


@pytest.mark.parametrize("command", ["plan", "check", "sweep"])
def test_commands_warn_of_swept_parameters(hydrofdi, experiment_file, command):
    config = experiment_file("record: {duration: 2 s}\nsweep: {grid: {fluid.free_air: [0.005, 0.05]}}\n")
    result = hydrofdi(command, config)
    assert (result.stdout + result.stderr).count(AIR) == 1
    assert result.returncode == 0


@pytest.mark.parametrize(
    ("settings", "names"),
    [
        (["friction.bristle_stiffness=1e6", "friction.law=smooth"], ["friction.bristle_stiffness"]),
        (["friction.bristle_stiffness=1e6", "sweep.grid.friction.law=[threshold, smooth]"], ["friction.bristle_stiffness"]),
        (["friction.bristle_stiffness=1e6", "sweep.grid.friction.law=[threshold, lugre]"], []),
        (["friction.bristle_stiffness=1e6", "sweep.union=[{grid: {friction.law: [lugre]}}]"], []),
        (["control.integral_gain=1", "control.law=p"], ["control.integral_gain"]),
        (["control.proportional_gain=1"], ["control.proportional_gain"]),
        (["control.integral_gain=1", "control.law=pi"], []),
        (["control.proportional_gain=1", "baseline.control.law=p"], []),
        (["input.amplitude=1", "control.law=p"], ["input.amplitude"]),
        (["load.seed=1"], ["load.seed"]),
        (["load.seed=1", "ensemble.sample={count: 2, over: {load.random_force: {uniform: [0, 10]}}}"], []),
        (["leakage.onset_duration=2", "leakage.onset=step"], ["leakage.onset_duration"]),
        (["fluid.free_air=0.005"], []),
        (["pressure_1_sensor.noise_bandwidth=1e3"], ["pressure_1_sensor.noise_bandwidth"]),
        (["pressure_1_sensor.noise_bandwidth=1e3", "sweep.grid.pressure_1_sensor.noise=[0, 1e3]"], []),
        (["measurement.anti_alias_order=2"], ["measurement.anti_alias_order"]),
        (["measurement={anti_alias: 200, anti_alias_order: 2}"], []),
        (["supply_sensor={order: first, bandwidth: 100, damping_ratio: 0.5}"], ["supply_sensor.damping_ratio"]),
    ],
)  # fmt: skip
def test_a_parameter_has_an_effect_in_some_run_or_is_reported(settings, names):
    assert [sentence.partition(" ")[0] for sentence in idle(*settings)] == names


def test_the_rows_of_a_file_have_no_amplitude(tmp_path):
    (tmp_path / "drive.csv").write_text("0,1\n")
    file = [f"input.file={tmp_path / 'drive.csv'}", "input.shape=csv"]
    assert len(idle(*file, "input.amplitude=1")) == 1


@pytest.mark.parametrize("config", CONFIGS, ids=lambda path: path.stem)
def test_what_comes_with_hydrofdi_has_an_effect(config):
    assert idle_parameters(load_experiment(config)) == []


def test_the_table_names_parameters_that_exist():
    assert {name for option, _, names in RULES for name in (option, *names)} <= set(parameter_names())


LEAKY = "record: {duration: 2 s}\nleakage: {internal_coefficient: 1e-8}\n"
UNION = "sweep: {union: [{grid: {friction.law: [smooth]}}, {grid: {leakage.law: [laminar]}}]}\n"


def test_plan_shows_of_a_union_what_each_point_sets(hydrofdi, experiment_file):
    lines = hydrofdi("plan", experiment_file(f"{LEAKY}{UNION}")).stdout.splitlines()
    assert "first point  friction.law = smooth" in lines
    assert "last point   leakage.law = laminar" in lines
