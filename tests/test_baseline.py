# ruff: noqa: E501
"""Baselines, distributions, and records that are too short."""

import json
import math
import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from pydantic import ValidationError
from scipy import stats

from hydrofdi.config import ExperimentConfig, expand_runs, load_experiment
from hydrofdi.config.experiment import STORED
from hydrofdi.errors import ConfigError
from tests import commands

STIFF = "fluid.bulk_modulus=1.2 GPa"
EBM = "sweep.grid.fluid.bulk_modulus=[0.8 GPa, 1.2 GPa, 1.4 GPa]"
SEALED = {"leakage.internal_flow": 0.0}


def baseline_of(*settings):
    return load_experiment(None, settings).baseline


def test_the_baseline_is_the_experiments_own_actuator_sealed_unless_it_says_otherwise():
    stiff = {"fluid.bulk_modulus": 1.2e9} | SEALED
    assert baseline_of(STIFF) == stiff
    assert baseline_of() == baseline_of(EBM) == {"fluid.bulk_modulus": 551e6} | SEALED
    assert baseline_of(STIFF, "baseline.friction.viscous=60") == stiff | {"friction.viscous": 60.0}
    sealed = baseline_of(STIFF, "baseline.leakage.internal_coefficient=0")
    assert sealed == {"fluid.bulk_modulus": 1.2e9, "leakage.internal_coefficient": 0.0}
    assert baseline_of(STIFF, "baseline.fluid.bulk_modulus=551 MPa")["fluid.bulk_modulus"] == 551e6


@pytest.mark.parametrize("leak", ["internal_coefficient=1e-9", "internal_flow=0.1 L/min"])
def test_a_baseline_that_leaks_is_a_mistake(leak):
    with pytest.raises(ConfigError, match=r"baseline\.leakage\.internal_.*not a healthy actuator"):
        baseline_of(f"baseline.leakage.{leak}")


def test_a_stored_request_keeps_the_baseline_that_it_names_and_may_have_defaults_of_keys_that_are_gone():
    """A request of earlier versions: stiff fluid, compared with the paper's."""
    stored = json.loads(load_experiment(None, [STIFF]).model_dump_json())
    stored["baseline"] = {"fluid.bulk_modulus": 551e6} | SEALED
    assert ExperimentConfig.model_validate(stored).baseline == stored["baseline"]
    experiment = load_experiment("detectability-smoke")
    stored = json.loads(experiment.model_dump_json())
    stored["replicates"] = {"count": 0, "seed": 0, "over": {}}
    stored["study"]["population"] |= {"method": "random", "correlation": None}
    assert ExperimentConfig.model_validate(stored, context=STORED) == experiment
    stored["study"]["population"]["method"] = "sobol"
    with pytest.raises(ValidationError):
        ExperimentConfig.model_validate(stored, context=STORED)


COUNT = 4096


def sampled(over, *settings, method="sobol", seed=1, **config):
    sample = f"sweep.sample={{method: {method}, count: {COUNT}, seed: {seed}, over: {{{over}}}}}"
    return load_experiment(config, [sample, *settings])


def drawn(over, *settings, **options):
    """The drawn values, parameter by parameter."""
    table = expand_runs(sampled(over, *settings, **options))
    return [np.array(table.runs[:COUNT].values(name)) for name in table.axes]


@pytest.mark.parametrize(("entry", "kind", "arguments"), [
    ("supply.pressure: {uniform: ±5 %}", "uniform", [0.95 * 17.2e6, 1.05 * 17.2e6]),
    ("supply.pressure: {uniform: +/-0.2 MPa}", "uniform", [17.0e6, 17.4e6]),
    ("valve.lap: {uniform: ±1 µm}", "uniform", [-1e-6, 1e-6]),
    ("actuator.mass: {normal: ±2.4 %}", "normal", [12.3, 0.024 * 12.3]),
    ("friction.scale: {triangular: ±30 %}", "triangular", [0.7, 1.0, 1.3]),
    ("pressure_1_sensor.bias: {normal: ± 25 kPa}", "normal", [0.0, 25e3]),
])  # fmt: skip
def test_plus_or_minus_is_taken_about_the_nominal_value(entry, kind, arguments):
    (law,) = sampled(entry).sweep.sample.over.values()
    assert law == {kind: pytest.approx(arguments)}
    for settings, nominal in (([], 600e6), (["fluid.bulk_modulus=1 GPa"], 1e9)):
        loaded = sampled("EBM: {uniform: ±10 %}", *settings, fluid={"bulk_modulus": 600e6})
        (law,) = loaded.sweep.sample.over.values()
        assert law == {"uniform": pytest.approx([0.9 * nominal, 1.1 * nominal])}


FLOWS = "sweep.grid.leakage.internal_flow=[0 L/min, 0.12 L/min, 0.5 L/min]"
DRAWN = "sweep.sample={count: 16, over: {friction.viscous: {uniform: [40, 60]}, actuator.mass: {uniform: [9, 15]}}}"
NOMINAL = "calibration.at=nominal"


def runs_of(*settings):
    return expand_runs(load_experiment(None, settings)).runs


def test_each_run_is_solved_for_its_own_actuator_by_default():
    runs = runs_of(FLOWS, DRAWN)
    assert runs.solutions() == {"flows": 2, "conditions": 16, "total": 32}
    for run in runs:
        assert run.calibration is None or run.calibration.friction == run.parameters.friction
    union = "sweep.union=[{grid: {leakage.internal_flow: [1e-6], friction.viscous: [50, 60]}}, {grid: {leakage.internal_flow: [2e-6]}}]"
    assert runs_of(union).solutions() == {"flows": 2, "conditions": 2, "total": 3}


def test_at_the_nominal_actuator_of_its_scenario_each_flow_is_solved_once():
    experiment = load_experiment(None, [FLOWS, DRAWN, NOMINAL, "baseline.supply.pressure=17 MPa"])
    runs = expand_runs(experiment).runs
    assert runs.solutions() == {"flows": 2, "conditions": 1, "total": 2}
    nominal = experiment.nominal_parameters
    leaky = [run for run in runs if run.calibration]
    assert len(leaky) == 32
    for run in leaky:
        solved = run.calibration
        assert solved.leakage.internal_flow == run.parameters.leakage.internal_flow
        assert (solved.friction, solved.actuator) == (nominal.friction, nominal.actuator)
        assert solved.supply.pressure == 17e6
    for run in runs_of(FLOWS, "sweep.zip.leakage.law=[orifice, laminar]", NOMINAL):
        assert run.calibration is None or run.calibration.leakage.law == "orifice"
    runs = runs_of(FLOWS, DRAWN, NOMINAL, "ensemble.grid.supply.pressure=[16 MPa, 18 MPa]")
    assert runs.solutions() == {"flows": 2, "conditions": 2, "total": 4}
    assert all(run.calibration is None or run.calibration.supply == run.parameters.supply for run in runs)


def test_a_nominal_coefficient_is_shared_and_flows_differ(tmp_path, experiment_file):
    file = experiment_file(
        "name: drawn\nrecord: {duration: 2 s}\ncalibration: {at: nominal}\nstore: {signals: none}\n"
        "sweep: {grid: {leakage.internal_flow: [0.5 L/min], supply.pressure: [10 MPa, 17.2 MPa]}}\n"
    )
    sweep = ("--out", tmp_path / "drawn")
    assert commands.run_json("plan", file, *sweep)["solutions"]["total"] == 1
    commands.run("sweep", file, *sweep, "--engine", "in-process", check=0)
    with h5py.File(tmp_path / "drawn" / "drawn.h5") as stored:
        assert len(set(stored["internal_leakage_coefficient"][:2])) == 1
        flows = stored["mean_internal_leakage_flow"][:2] * 60e3
    assert flows[1] == pytest.approx(0.5, rel=1e-3)
    assert flows[0] < 0.45


BASE = "name: base\nanalysis: {discard: 1 period}\nrecord: {duration: 4 s}\nstore: {signals: none}\n"


def _refusal(file: Path, *settings: str) -> str:
    with pytest.raises(ConfigError) as refused:
        expand_runs(load_experiment(file, settings))
    return str(refused.value)


@pytest.mark.parametrize("text", [
    "record: {duration: 2 s}",
    "record: {duration: 0.2 s}\nanalysis: {discard: 0 s}",
    "wavelet: {levels: 7, phase: 3}",
    "input: {period: 8 s}",
    "sweep: {grid: {input.period: [2 s, 4 s]}}",
    "sweep: {grid: {record.duration: [2 s, 8 s]}}",
    "wavelet: {levels: 8}",
])  # fmt: skip
def test_the_least_duration_and_the_levels_that_are_named_work_and_one_sample_or_level_does_not(
    experiment_file, tmp_path, text: str
) -> None:
    (tmp_path / "base.yaml").write_text(BASE)
    file = experiment_file(f"extends: base.yaml\n{text}\n")
    found = re.search(r"set record\.duration to (\S+) s or more", _refusal(file))
    assert found
    least = float(found[1])
    key = "sweep.grid.record.duration=[{} s]" if "record.duration:" in text else "record.duration={} s"
    expand_runs(load_experiment(file, [key.format(least)]))
    assert "set record.duration to" in _refusal(file, key.format(round(least - 0.002, 6)))
    if levels := re.search(r"or wavelet\.levels to (\d+)", _refusal(file)):
        expand_runs(load_experiment(file, [f"wavelet.levels={levels[1]}"]))
        assert "wavelet.levels" in _refusal(file, f"wavelet.levels={int(levels[1]) + 1}")
    assert levels or "levels: 8" not in text


LAWS = {
    "uniform: [40, 60]": stats.uniform(40, 20),
    "loguniform: [1, 100]": stats.loguniform(1, 100),
    "normal: [50, 5]": stats.norm(50, 5),
    "truncated_normal: [50, 20, 45, 90]": stats.truncnorm(-0.25, 2.0, loc=50, scale=20),
    "truncated_normal: [5, 1, 50, 60]": stats.truncnorm(45, 55, loc=5, scale=1),
    "lognormal: [50, 1.5]": stats.lognorm(math.log(1.5), scale=50),
    "triangular: [10, 20, 60]": stats.triang(0.2, loc=10, scale=50),
    "triangular: [10, 10, 60]": stats.triang(0.0, loc=10, scale=50),
}


@pytest.mark.parametrize("method", ["sobol", "lhs", "random"])
def test_draws_follow_their_distribution_and_their_seed(method):
    for law, expected in LAWS.items():
        (values,) = drawn(f"friction.viscous: {{{law}}}", method=method)
        distance = stats.kstest(values, expected.cdf).statistic
        assert distance < (2.0 / math.sqrt(COUNT) if method == "random" else 2.0 / COUNT), law
    over = "friction.viscous: {truncated_normal: [50, 1 kN·s/m, 45, 60]}, actuator.mass: {triangular: [9, 9, 9.1]}"
    viscous, mass = drawn(over, method=method)
    assert 45 <= viscous.min() < 45.1 < 59.9 < viscous.max() <= 60
    assert 9 <= mass.min() <= mass.max() <= 9.1
    again, other = (drawn(over, method=method, seed=seed)[0] for seed in (1, 2))
    assert (viscous == again).all()
    assert (viscous != other).any()
    assert {*drawn("actuator.mass: {choice: [12, 13]}", method=method)[0]} == {12.0, 13.0}
    whole = expand_runs(sampled("input.seed: {integers: [3, 6]}", "input.shape=steps", method=method)).runs
    assert {(value, type(value)) for value in whole.values("input.seed")} == {(n, int) for n in (3, 4, 5, 6)}


def test_deviations_have_the_unit_of_the_parameter_and_factors_have_none():
    (values,) = drawn("EBM: {truncated_normal: [600 MPa, 20 MPa, 0.5 GPa, 0.7 GPa]}")
    assert values.std() == pytest.approx(20e6, rel=0.01)
    (values,) = drawn("EBM: {lognormal: [600 MPa, 1.1]}")
    assert np.median(values) == pytest.approx(600e6, rel=1e-3)
    assert np.quantile(values, 0.8413) / 600e6 == pytest.approx(1.1, rel=1e-3)
