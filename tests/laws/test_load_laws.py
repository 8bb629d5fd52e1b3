"""Laws of the load, of rest, and of the balances."""

import ctypes
import math
import platform
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from free_motion import FREE, FRICTIONLESS, HELD, free_motion
from test_second_solver import VARIANTS

from hydrofdi.config import RunParameters, load_experiment
from hydrofdi.physics import NEGLIGIBLE, settled
from hydrofdi.simulation import batch, inputs
from hydrofdi.simulation.balances import balance_residuals
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.lanes import HIDDEN
from hydrofdi.simulation.sensing import Measurement
from tests.machines import HOSES, Values, machine

AREA = RunParameters().actuator.piston_area
AT_REST = machine({
    "input.amplitude": 0.0, "record.duration": 10.0, "actuator.load_stiffness": 50e3, "friction.scale": 0.0,
    "friction.viscous": 2000.0,
})  # fmt: skip


def test_shut_leaking_cylinders_yield_to_their_loads_until_the_spring_holds_them() -> None:
    loads = np.linspace(-800.0, 800.0, 20)
    runs = [AT_REST.with_values({"load.constant_force": force}) for force in loads.tolist()]
    record = simulate_batch(runs, [1e-8] * 20)
    difference = (record.chamber_1_pressure - record.chamber_2_pressure)[:, -1]
    position = record.piston_position[:, -1]
    np.testing.assert_allclose(AREA * difference, loads + 50e3 * position, atol=0.5)
    np.testing.assert_allclose(position, -loads / 50e3, atol=2e-5)


def test_random_load_is_seeded_and_held_and_a_slow_one_reaches_the_same_levels_evenly() -> None:
    values = {"load.random_force": 500.0, "load.random_period": 0.1, "load.constant_force": 100.0}
    own = [{}, {}, {"load.seed": 2}, {"load.random_change": 0.06}]
    force = simulate_batch([AT_REST.with_values(values | each) for each in own], [1e-9] * 4).load_force
    np.testing.assert_array_equal(force[0], force[1])
    levels, _, other, slow = force.reshape(4, 100, 50)
    assert np.all(levels == levels[:, :1])
    assert np.abs(levels - 100.0).max() <= 500.0
    assert abs(np.corrcoef(levels[:, 0], other[:, 0])[0, 1]) < 0.4
    np.testing.assert_array_equal(slow[:, 31:], levels[:, 31:])
    np.testing.assert_allclose(np.diff(slow[1:, :30], n=2), 0.0, atol=1e-9)
    np.testing.assert_allclose(slow[1:, 0], levels[:-1, 0])


def test_free_mass_bounces_off_an_end_stop_with_its_speed() -> None:
    """A chamber pressure that never changes leaves the mass free; the stop is a spring."""
    values = FREE | FRICTIONLESS | {
        "actuator.end_stop_stiffness": 20e6, "actuator.end_stop_position": 0.05, "fluid.bulk_modulus": 1.0,
    }  # fmt: skip
    motion = free_motion([values] * 2, [{"velocity": 0.5}, {"velocity": -0.5}], [0.0, 0.0], 0.2, 1e-5)
    assert motion["velocity"][0, -1] == pytest.approx(-0.5, rel=1e-4)
    depth = 0.5 * np.sqrt(12.3 / 20e6)
    assert motion["position"][0].max() == pytest.approx(0.05 + depth, rel=1e-4)
    np.testing.assert_allclose(motion["position"][0], -motion["position"][1], atol=1e-12)


UNDERFLOW = {"x86_64": 0x10, "aarch64": 0x08}.get(platform.machine(), 0) if sys.platform == "linux" else 0
"""The processor's mark of a result that became subnormal, by the C library's number."""
HELD_INPUT = {"input.period": 10.0}
PRESSED = {"control.amplitude": 0.5, "actuator.load_stiffness": 1e7, "valve.natural_frequency": 225.0}
"""A reference out of reach, so that the controller stays at its limit and the spool comes to rest."""
DRAINED = {
    "input.amplitude": 0.0, "control.amplitude": 0.0,
    "supply.return_pressure": 0.0, "leakage.external_coefficient": 1e-10,
}  # fmt: skip


def watched(kernel: Callable[..., None], underflowed: list[str]) -> Callable[..., None]:
    """A kernel that notes whether an operation underflowed."""

    def advance(*given: Any) -> None:
        ctypes.CDLL(None).feclearexcept(UNDERFLOW)
        kernel(*given)
        if ctypes.CDLL(None).fetestexcept(UNDERFLOW):
            underflowed.append(kernel.__name__)

    return advance


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> RunParameters:
    """A valve that moves and is then closed."""
    file: Path = tmp_path_factory.mktemp("input") / "stop.csv"
    file.write_text("time [s], voltage [V]\n0, 2\n0.2, -1\n0.3, 0\n")
    return load_experiment(None, ["input.shape=csv", f"input.file={file}"]).nominal_parameters


@pytest.mark.skipif(not UNDERFLOW, reason="how this processor marks an underflow is not known")
@pytest.mark.parametrize("values", VARIANTS)
def test_nothing_becomes_subnormal_at_rest(values: Values, stopped: RunParameters, monkeypatch) -> None:
    underflowed: list[str] = []
    for module, name in ((batch, "advance_lanes"), (inputs, "advance_spools")):
        monkeypatch.setattr(module, name, watched(getattr(module, name), underflowed))
    values = values | {"record.duration": 2.0}
    nominal = RunParameters().with_values(values)
    runs = [nominal.with_values(rest) for rest in (HELD_INPUT, HELD_INPUT | PRESSED, DRAINED)]
    if not nominal.control.is_closed and nominal.input.shape == "square":
        runs.append(stopped.with_values(values))
    trajectory = simulate_batch(runs, [3e-9] * len(runs))
    assert not underflowed
    assert [outcome.status for outcome in trajectory.outcomes] == ["ok"] * len(runs)


def test_a_closed_valve_comes_to_rest_where_what_is_negligible_settles(stopped: RunParameters) -> None:
    opening = simulate_batch([stopped.with_values({"record.duration": 2.0})], [0.0]).spool_position[0]
    assert np.abs(opening).max() > 1e-5
    assert opening[-1] == 0.0
    assert settled(0.99 * NEGLIGIBLE) == settled(-0.99 * NEGLIGIBLE) == 0.0
    assert settled(-NEGLIGIBLE) == -NEGLIGIBLE
    assert np.isnan(settled(np.nan))


def test_balances_close_at_a_small_step_and_open_where_leakage_or_friction_is_forged() -> None:
    times = {"record.step": 2e-5, "record.sampling_frequency": 50e3, "record.duration": 1.0}
    fine = RunParameters().with_values(times | {"input.period": 1.0})
    runs = [fine, fine.with_values({"leakage.external_coefficient": 2e-13, "fluid.bulk_modulus": 827e6})]
    trajectory = simulate_batch(runs, [0.0, 2e-9])
    residuals = balance_residuals(runs, trajectory)
    assert np.all(residuals.volume < 1e-6)
    assert np.all(residuals.energy < 1e-6)
    alone = balance_residuals(runs[1:], simulate_batch(runs[1:], [2e-9]))
    assert (alone.volume[0], alone.energy[0]) == (residuals.volume[1], residuals.energy[1])
    without = balance_residuals(runs, replace(trajectory, leakage_coefficient=np.zeros(2)))
    assert without.volume[1] > 1e-3
    assert without.energy[1] > 1e-3
    others = [run.with_values({"friction.coulomb": 300.0, "friction.breakaway": 350.0}) for run in runs]
    rubbing = balance_residuals(others, trajectory)
    assert np.all(rubbing.energy > 1e-4)
    assert np.all(rubbing.volume < 1e-6)


def test_hose_rings_at_its_own_frequency_and_carries_flow_against_its_resistance() -> None:
    """Between a shut valve and a held piston: ω² = (β_h/V_h + β/V)/I_h, decay rate R_h/(2 I_h)."""
    hose = {"actuator.hose_volume": 40e-6, "actuator.hose_inertance": 2e7, "actuator.hose_resistance": 1e9}
    start = {"line_pressure_1": 9e6, "pressure_1": 8e6, "line_pressure_2": 8e6, "pressure_2": 8e6}
    motion = free_motion([hose | HELD], [start], [0.0], 0.05, 1e-5, HOSES)
    omega = math.sqrt((400e6 / 40e-6 + 551e6 / 280e-6) / 2e7)
    rate, time = 1e9 / (2.0 * 2e7), 1e-5 * np.arange(motion["line_flow_1"].shape[1])
    damped = math.sqrt(omega**2 - rate**2)
    flow = 1e6 / (2e7 * damped) * np.exp(-rate * time) * np.sin(damped * time)
    np.testing.assert_allclose(motion["line_flow_1"][0], flow, atol=1e-6 * flow.max())
    assert np.ptp(motion["pressure_2"][0]) < 1.0
    motion = free_motion(
        [hose | FREE | {"leakage.internal_coefficient": 5e-9}], [{}], [44e-6], 0.5, 1e-4, HOSES
    )
    for number, sign in ((1, 1.0), (2, -1.0)):
        fall = sign * (motion[f"line_pressure_{number}"] - motion[f"pressure_{number}"])[0, -500:].mean()
        assert fall == pytest.approx(1e9 * motion[f"line_flow_{number}"][0, -500:].mean(), rel=1e-3)
        assert fall > 1e4


def test_sensor_at_the_valve_shows_the_pressure_of_the_hose() -> None:
    run = machine({"measurement.pressures_at": "valve"}, HOSES)
    runs = [run, run.with_values({"pressure_1_sensor.delay": 2e-3})]
    sensors = Measurement(runs)
    truth = simulate_batch(runs, [2e-9] * 2, sensors)
    shown = sensors.show(truth)
    np.testing.assert_array_equal(shown.chamber_1_pressure[0], truth.line_1_pressure[0])
    np.testing.assert_array_equal(shown.chamber_2_pressure, truth.line_2_pressure)
    np.testing.assert_allclose(shown.chamber_1_pressure[1, 1:], truth.line_1_pressure[1, :-1], rtol=1e-12)
    assert np.abs(shown.chamber_1_pressure[0] - truth.chamber_1_pressure[0]).max() > 1e4


def test_cylinder_on_a_foundation_gives_way_to_the_force_on_the_load() -> None:
    """At rest: K_b x_b = −A (P_1 − P_2) without friction; the load's spring holds the other end."""
    run = machine({
        **FRICTIONLESS, "friction.viscous": 2e3, "actuator.foundation_stiffness": 5e6,
        "actuator.foundation_damping": 20e3, "record.duration": 2.0, "input.period": 4.0,
    })  # fmt: skip
    record = simulate_batch([run], [5e-9])
    support = record.hidden_states[0, list(HIDDEN).index("support"), -1]
    force = AREA * (record.chamber_1_pressure - record.chamber_2_pressure)[0, -1]
    assert abs(force) > 500.0
    assert 5e6 * support == pytest.approx(-force, rel=1e-2)
