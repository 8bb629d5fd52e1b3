"""Warnings before a run: unusual values, parameters without effect, and what a data sheet lacks."""
# ruff: noqa: E501

from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.api.warnings import STUDY_RULES, said
from hydrofdi.config import load_experiment
from hydrofdi.config.plausibility import RULES, idle_parameters, unusual_values
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.units import parse_quantity
from tests.commands import run

CONFIGS = sorted((Path(__file__).parents[2] / "configs").glob("*.yaml"))


def unusual(*settings, with_sweep=True):
    return unusual_values(load_experiment(settings=settings), with_sweep=with_sweep)


STRANGE = [
    ["fluid.bulk_modulus=551"], ["baseline.fluid.bulk_modulus=551"],
    ["ensemble.grid.fluid.bulk_modulus=[551, 551 MPa]"], ["sweep.zip.fluid.bulk_modulus=[551, 689]"],
    ["sweep.union=[{grid: {fluid.bulk_modulus: [551]}}]"],
    ["sweep.sample.over.fluid.bulk_modulus={uniform: [551, 1e9]}", "sweep.sample.count=2"],
    ["input.amplitude=-2000"], ["friction.breakaway=150"], ["fluid.bulk_modulus=12.000 bar"],
    ["valve.damping_ratio=0.001"], ["valve.lap=-1e-12"], ["fluid.free_air=5"], ["pressure_1_sensor.noise=0.02"],
    ["position_sensor.bias=-20"], ["sweep.grid.voltage_sensor.highest=[10 V, 1 MV]"],
    ["velocity_sensor={order: first, bandwidth: 10 MHz}"],
]  # fmt: skip
USUAL = [
    ["sweep.sample.over.fluid.bulk_modulus={normal: [551e6, 1e7]}", "sweep.sample.count=2"],
    ["leakage.internal_flow=0"], ["input.amplitude=-2"], ["analysis.discard=1 period"],
    ["sweep.zip.friction.coulomb=[100, 300]", "sweep.zip.friction.breakaway=[100, 300]"],
]  # fmt: skip


@pytest.mark.parametrize("settings", STRANGE)
def test_every_stated_value_counts(settings):
    (sentence,) = unusual(*settings)
    assert sentence.partition(" = ")[0].rpartition(".")[2] in settings[0]


@pytest.mark.parametrize("settings", USUAL)
def test_a_usual_value_is_not_warned_of(settings):
    assert unusual(*settings) == []


@pytest.mark.parametrize(
    "config", [None, *CONFIGS], ids=lambda path: "nominal" if path is None else path.stem
)
def test_what_comes_with_hydrofdi_is_usual(config):
    assert unusual_values(load_experiment(config)) == []


def test_bounds_are_an_order_of_magnitude_around_the_nominal_value():
    experiment, n_bound = load_experiment(), 0
    for name in parameter_names():
        quantity, value = parameter_quantity(name), experiment.value(name)
        if quantity and quantity.usual:
            low, high = (parse_quantity(bound, quantity.unit) for bound in quantity.usual)
            assert low * 100 <= high, name
            assert not value or 7 * low <= value <= high / 7, name
            n_bound += 1
    assert n_bound > 35


def test_most_quantities_have_bounds():
    unbounded = {
        name for name in parameter_names() if (quantity := parameter_quantity(name)) and not quantity.usual
    }
    assert unbounded == {"analysis.discard", "leakage.onset_duty"}


def idle(*settings):
    return idle_parameters(load_experiment(settings=settings))


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


def test_the_table_names_parameters_that_exist():
    assert {name for option, _, names in RULES for name in (option, *names)} <= set(parameter_names())


FAST = {
    "record": {"duration": "4 s"},
    "control": {"law": "p", "amplitude": "20 mm", "proportional_gain": "2000 V/m", "voltage_limit": "1 V"},
}
STUDY = {"healthy": {"fit": 4, "test": 4}, "faults": {"leakage.internal_flow": [1e-6], "each": 2, "fit": 0}}


def test_a_calm_controller_and_an_open_loop_are_not_told():
    calm = {**FAST, "control": {**FAST["control"], "proportional_gain": "20 V/m"}}
    assert hydrofdi.simulate({"name": "calm", **calm}).saturation == []
    assert hydrofdi.simulate({"name": "open", "record": FAST["record"]}).saturation == []


def test_simulate_prints_the_saturation(tmp_path):
    settings = ["control.law=p", "control.proportional_gain=2000 V/m", "control.voltage_limit=1 V"]
    options = [part for each in (*settings, "record.duration=4 s") for part in ("--set", each)]
    assert "warning: the controller is at control.voltage_limit" in run("simulate", *options).stderr


@pytest.mark.parametrize(
    ("more", "is_told"),
    [
        ({"indicators": {"flow_balance": {"spool": "command"}}}, True),
        ({"indicators": {"flow_balance": {"spool": "command", "supply": "sum"}}}, False),
        ({"indicators": {"flow_balance": {}}, "supply_sensor": {"noise": "5 kPa"}}, False),
        ({"indicators": {"dwt": {}}}, False),
    ],
)
def test_a_study_says_that_it_reads_a_supply_pressure_that_no_sensor_measures(more, is_told):
    sentences = said(STUDY_RULES, load_experiment({"name": "press", "study": STUDY, **more}), None)
    assert any("no supply_sensor is set" in each for each in sentences) == is_told


def test_the_commented_balance_works_as_it_stands(tmp_path):
    run("init", "press", cwd=tmp_path, check=0)
    text = (tmp_path / "press.yaml").read_text()
    head, _, tail = text.partition("  # pressure_balance:")
    block, _, rest = tail.partition("\n\n")
    lines = ("  # pressure_balance:" + block).splitlines()
    shown = "\n".join(line.replace("  # ", "  ", 1) for line in lines)
    (tmp_path / "press.yaml").write_text(f"{head}{shown}\n\n{rest}")
    assert "pressure_balance" in load_experiment(tmp_path / "press.yaml").indicators


@pytest.mark.parametrize("command", ["plan", "check", "sweep"])
def test_commands_warn_of_values_parameters_and_sampling_once(hydrofdi, experiment_file, command):
    config = experiment_file(
        "record: {duration: 2 s}\nmeasurement: {anti_alias: 400 Hz}\n"
        "sweep: {zip: {actuator.mass: [12.3, 1230000], fluid.free_air: [0.005, 0.05]}}\n"
    )
    result = hydrofdi(command, config)
    said = [line for line in (result.stdout + result.stderr).splitlines() if line.startswith("warning")]
    for key in ("actuator.mass", "fluid.free_air"):
        assert sum(f" {key} " in line for line in said) == 1
    assert any("measurement.anti_alias" in line for line in said) == (command != "sweep")
    assert result.returncode in (0, 1)
