"""Warnings of values far from the usual ones: most often a unit that was left out."""
# ruff: noqa: E501

from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.plausibility import unusual_values
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.units import parse_quantity

CONFIGS = sorted((Path(__file__).parents[2] / "configs").glob("*.yaml"))
MODULUS = (
    "fluid.bulk_modulus = 551 Pa is far below the usual 10 MPa … 10 GPa; a number without a unit is in SI"
)


def unusual(*settings, with_sweep=True):
    return unusual_values(load_experiment(settings=settings), with_sweep=with_sweep)


def test_simulate_warns_and_goes_on(hydrofdi):
    result = hydrofdi("simulate", "--set", "record.duration=2 s", "--set", "fluid.bulk_modulus=551", "--json")
    assert result.stderr.splitlines()[0] == f"warning: {MODULUS}"
    assert result.stdout.startswith("{")


@pytest.mark.parametrize("command", ["plan", "check", "sweep"])
def test_commands_warn_of_swept_values(hydrofdi, experiment_file, command):
    config = experiment_file(
        "record: {duration: 2 s}\nsweep: {grid: {actuator.mass: [12.3, 12.3 g, 1230000]}}\n"
    )
    result = hydrofdi(command, config)
    said = (result.stdout + result.stderr).splitlines()
    (line,) = [line for line in said if line.startswith("warning") and "the usual" in line]
    assert line.endswith(
        " actuator.mass = 1.23e+06 kg is far above the usual 10 g … 100000 kg;"
        " a number without a unit is in SI"
    )
    assert result.returncode in (0, 1)


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


def test_nominal_value_that_a_sweep_replaces_does_not_count():
    settings = "friction.viscous=5e9", "sweep.grid.friction.viscous=[50]"
    assert unusual(*settings) == []
    (sentence,) = unusual(*settings, with_sweep=False)
    assert sentence.startswith("friction.viscous = 5e+09 N·s/m is far above")


def test_a_nominal_bulk_modulus_counts_as_that_of_the_baseline():
    assert unusual("fluid.bulk_modulus=551", "sweep.grid.fluid.bulk_modulus=[551 MPa]") == [MODULUS]


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


LATE = "input.file = drive.csv: 1 of 3 rows lie beyond record.duration = 2 s, the last at 500 s"
LARGE = "input.file = drive.csv: the largest voltage = 2000 V is far above the usual 1 mV … 100 V; a number without a unit is in SI"


def test_rows_beyond_the_record_and_strange_values_of_a_file_are_reported(hydrofdi, tmp_path):
    (tmp_path / "drive.csv").write_text("0,2\n1,-2000\n500,2\n")
    settings = ["record.duration=2 s", "input.shape=csv", f"input.file={tmp_path / 'drive.csv'}"]
    result = hydrofdi("simulate", *(part for setting in settings for part in ("--set", setting)))
    assert result.stderr.splitlines()[:2] == [f"warning: {LATE}", f"warning: {LARGE}"]
    assert unusual(*settings, "sweep.grid.record.duration=[2 s, 500 s]") == [LARGE]


def test_positions_of_a_file_are_held_against_the_usual_reference(tmp_path):
    (tmp_path / "drive.csv").write_text("time [s],position [m]\n0,0\n1,20\n")
    settings = ["control.law=p", "input.shape=csv", f"input.file={tmp_path / 'drive.csv'}"]
    (sentence,) = unusual(*settings)
    assert sentence.startswith(
        "input.file = drive.csv: the largest position = 20 m is far above the usual 1 µm"
    )


def test_a_leakage_without_a_unit_that_no_actuator_reaches_is_told_its_unit(hydrofdi):
    bare, stated = (
        hydrofdi("simulate", "--set", "record.duration=2 s", "--set", f"leakage.internal_flow={flow}")
        for flow in ("0.5", "500 L/min")
    )
    assert "no K_i gives a mean leakage of 3e+04 L/min; a number without a unit is in m³/s" in bare.stderr
    assert "500 L/min" in stated.stderr
    assert "without a unit" not in stated.stderr
