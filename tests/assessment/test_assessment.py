"""Looking at an experiment before it is run, and solving leakage flows."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.api.sweeps import calibrate
from hydrofdi.config import RunParameters, expand_runs, load_experiment
from hydrofdi.execution.checking import select_runs
from hydrofdi.physics.cylinder import internal_leakage_flow
from hydrofdi.quality.machine import natural_frequency
from hydrofdi.simulation.batch import simulate_batch
from tests.commands import run, run_json

SHORT = ("record.duration=2 s", "input.period=1 s")


def test_every_distinct_run_is_inspected_once():
    flows, moduli = "leakage.internal_flow=[0.12 L/min, 0.89 L/min]", "fluid.bulk_modulus=[551 MPa, 827 MPa]"
    axes = (flows, moduli, "friction.viscous=[50, 60]")
    found = hydrofdi.check(load_experiment(settings=[*SHORT, *(f"sweep.grid.{axis}" for axis in axes)]))
    columns = ((mode["bulk_modulus"], mode["leakage_coefficient"]) for mode in found.modes)
    seen = {*zip(columns, (mode["labels"]["friction.viscous"] for mode in found.modes), strict=True)}
    assert len(seen) == len(found.modes) == 3 * 2 * 2, "leakages and sealed, EBM, frictions"
    assert (found.n_left_out, found.n_run) == (0, 12)


def test_a_machine_that_cannot_lift_its_load_is_shown_without_the_leaks_that_it_does_not_reach():
    found = hydrofdi.check(
        {
            "load": {"constant_force": 20e3},
            "actuator": {"load_stiffness": 0.0},
            "record": {"duration": 2.0},
            "sweep": {"grid": {"leakage.internal_flow": [0.0, 15e-3]}},
        }
    )
    assert [mode["leakage_coefficient"] for mode in found.modes] == [0.0]
    assert found.n_left_out == 1
    assert any("no K_i" in each for each in found.problems)
    changed = [each["quantity"] for each in found.plausibility if each["change"]]
    assert changed[0].startswith("load")


def test_runs_of_a_large_grid_are_spread_evenly_over_it_with_both_ends():
    moduli, leaks = "{linspace: [500 MPa, 900 MPa, 20]}", "{linspace: [1e-9, 3e-8, 20]}"
    axes = (f"fluid.bulk_modulus={moduli}", f"leakage.internal_coefficient={leaks}")
    settings = [*SHORT, *(f"sweep.grid.{axis}" for axis in axes)]
    experiment = load_experiment(settings=settings)
    jobs, n_left_out, _ = select_runs(experiment, expand_runs(experiment), most=16)
    assert (len(jobs), n_left_out) == (16, 405)
    *swept, third, second, first, last = jobs
    assert all(job.leakage_coefficient == 0.0 for job in (third, second, first, last)), "healthy"
    corners = [(each.parameters.fluid.bulk_modulus, each.leakage_coefficient) for each in swept]
    np.testing.assert_allclose([corners[0], corners[-1]], [(500e6, 1e-9), (900e6, 3e-8)])
    np.testing.assert_allclose(np.diff([modulus for modulus, _ in corners]), 400e6 / 11, rtol=0.6)
    assert len({coefficient for _, coefficient in corners}) > 6


def test_what_follows_from_parameters_alone_covers_runs_that_are_not_simulated():
    moduli = np.linspace(600e6, 700e6, 100)
    moduli[[1, 98]] = 900e6, 500e6
    grid = {"fluid.bulk_modulus": moduli.tolist()}
    found = hydrofdi.check({"record": {"duration": 2.0}, "sweep": {"grid": grid}})
    assert not {mode["bulk_modulus"] for mode in found.modes} & {500e6, 900e6}
    (shown,) = (each for each in found.plausibility if each["quantity"].startswith("natural"))
    runs = (RunParameters().with_values({"fluid.bulk_modulus": each}) for each in (500e6, 900e6))
    assert [shown["least"], shown["largest"]] == [*map(natural_frequency, runs)]


def options(*settings):
    return [part for setting in (*SHORT, *settings) for part in ("--set", setting)]


def test_check_says_no_where_the_step_is_unstable():
    record = run_json("check", *options("record.step=1 ms"), check=1)
    assert record["binding"] == "friction zone"
    assert any("friction zone" in problem for problem in record["problems"])


def test_calibrated_coefficient_leaks_the_flow_that_was_asked_for():
    flows = [0.12e-3 / 60, 0.89e-3 / 60]
    targets = calibrate(load_experiment(settings=SHORT), flows=flows)
    np.testing.assert_allclose(targets["flow"], flows, rtol=1e-6)
    own = RunParameters().with_values({"record.duration": 2.0, "input.period": 1.0})
    for target in targets:
        trajectory = simulate_batch([own], [target["coefficient"]])
        difference = trajectory.chamber_1_pressure - trajectory.chamber_2_pressure
        orifice = np.abs(internal_leakage_flow(difference, target["coefficient"])).mean()
        assert orifice == pytest.approx(target["flow"], rel=1e-6)
    for flow in ("50 L/min", "9 bar", "-1 L/min"):
        run("calibrate", "--flow", flow, *options(), check=2)


def test_step_limit_is_that_of_the_stiffest_run_of_a_sweep():
    one, stiffest = (
        hydrofdi.check(load_experiment(settings=(*SHORT, *more))).step_limits["friction zone"]
        for more in ((), ("sweep.grid={friction.scale: [1, 2]}",))
    )
    assert stiffest == pytest.approx(0.5 * one, rel=1e-2)


def test_sensors_do_not_touch_what_is_inspected_or_calibrated():
    noisy = ("pressure_1_sensor.noise=1 MPa", "velocity_sensor.bias=1 m/s", "measurement.jitter=0.1 ms")
    plain, loud = (load_experiment(settings=settings) for settings in (SHORT, SHORT + noisy))
    assert hydrofdi.check(plain).modes == hydrofdi.check(loud).modes
    first, second = (calibrate(each, flows=[1.5e-5]).to_dict() for each in (plain, loud))
    assert first == second
