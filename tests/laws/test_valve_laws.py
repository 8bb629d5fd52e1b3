"""Laws of the valve: flow, edges, null and hysteresis."""

import math
from typing import Any

import numpy as np
import pytest
from free_motion import FREE, FRICTIONLESS, free_motion

from hydrofdi.config import RunParameters
from hydrofdi.config.request import EDGES
from hydrofdi.quality.machine import hydraulic_mode, step_limits
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.inputs import Drive, Spools, largest_opening
from tests.machines import LOOP, machine

VALVE = RunParameters().valve
SPOOL_GAIN = VALVE.spool_gain


def _spool(step, ratio=0.7, **limits):
    """Time and spool position after a step of 2 V; with the second-order lag of this damping ratio."""
    valve = {"valve.damping_ratio": ratio} | {f"valve.{name}": value for name, value in limits.items()}
    run = RunParameters().with_values(
        {"record.step": step, "record.sampling_frequency": round(1.0 / step), **valve}
    )
    time = step * np.arange(round(0.02 / step))
    _, stages = Spools([Drive.of(run)], run.record).advance(0, time.size)
    omega = 2.0 * math.pi * 175.0
    damped = omega * math.sqrt(1.0 - ratio**2)
    wave = np.cos(damped * time) + ratio * omega / damped * np.sin(damped * time)
    return time, stages[:, 0, 0], 44e-6 * (1.0 - np.exp(-ratio * omega * time) * wave)


def test_spool_follows_a_voltage_step_like_a_second_order_lag_with_an_error_of_fourth_order() -> None:
    _, position, expected = _spool(1e-4, 0.3)
    np.testing.assert_allclose(position, expected, atol=1e-5 * 44e-6)
    found = [_spool(step) for step in (2e-4, 1e-4, 5e-5)]
    errors = np.array([np.abs(position - expected).max() for _, position, expected in found])
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 4.0) < 0.3)


def test_limited_spool_stops_at_its_largest_opening_and_travels_at_its_largest_speed() -> None:
    _, position, _ = _spool(1e-4, 0.3, largest_opening=30e-6)
    assert position.max() == 30e-6
    assert position[-1] == pytest.approx(30e-6, rel=0.05)
    time, position, _ = _spool(1e-4, largest_speed=5e-3)
    cruising = (time > 2e-3) & (time < 6e-3)
    np.testing.assert_allclose(np.diff(position[cruising]), 5e-3 * 1e-4, rtol=1e-9)
    assert position[-1] == pytest.approx(44e-6, rel=0.02)


def _of_every_edge(**values: float) -> dict[str, float]:
    return {f"{edge}.{name}": value for edge in EDGES for name, value in values.items()}


def test_what_all_edges_have_of_their_own_is_what_the_valve_has() -> None:
    """Lap and clearance add up, gains multiply."""
    own = _of_every_edge(lap=-1e-6, lap_leakage=2e-14, flow_gain_ratio=0.5)
    valve = {"valve.lap": -1e-6, "valve.lap_leakage": 2e-14, "valve.flow_gain": 0.5 * VALVE.flow_gain}
    batch = simulate_batch([machine(own), machine(valve)], [2e-9, 2e-9])
    np.testing.assert_array_equal(*batch.chamber_1_pressure)


@pytest.mark.parametrize(
    ("edge", "opening"),
    [("supply_1_edge", 1), ("return_1_edge", -1), ("supply_2_edge", -1), ("return_2_edge", 1)],
)
@pytest.mark.parametrize("values", [{"lap": 3e-6}, {"flow_gain_ratio": 0.7}], ids=["lap", "gain"])
def test_an_edge_acts_where_it_is_open_alone(edge: str, opening: int, values: dict[str, float]) -> None:
    own = {f"{edge}.{name}": value for name, value in values.items()}
    for side in (1, -1):
        motion = free_motion([FREE | own, FREE], [{}, {}], [side * 20e-6] * 2, 0.1, 1e-4)
        differs = np.ptp(motion["position"][0] - motion["position"][1]) > 1e-5
        assert differs == (side == opening)


@pytest.mark.parametrize(("edge", "end"), [("supply", 17.2e6), ("return", 0.0)])
@pytest.mark.parametrize("chamber", [1, 2])
def test_clearance_of_an_edge_brings_its_chamber_to_what_lies_behind(edge, chamber, end):
    """A shut valve with one clearance: the chamber goes to supply or return with V/(β c_lap)."""
    values = FREE | {"valve.lap": 5e-6, "fluid.bulk_modulus": 551e6, "actuator.mass": 1e12}
    values |= {f"{edge}_{chamber}_edge.lap_leakage": 5e-13}
    motion = free_motion([values], [{"pressure_1": 5e6, "pressure_2": 5e6}], [0.0], 1.0, 1e-4)
    time = 1e-4 * np.arange(motion["pressure_1"].shape[1])
    expected = end + (5e6 - end) * np.exp(-time * 551e6 * 5e-13 / 280e-6)
    np.testing.assert_allclose(motion[f"pressure_{chamber}"][0], expected, rtol=1e-6, atol=10.0)
    assert np.ptp(motion[f"pressure_{3 - chamber}"][0]) < 10.0


def test_bounds_follow_the_edge_that_goes_farthest() -> None:
    base, part = machine({}, {}), "leakage of the chambers"
    far = base.with_values({"return_2_edge.lap": -3e-6, "supply_1_edge.lap": 5e-6})
    assert largest_opening(far) == pytest.approx(largest_opening(base) + 3e-6)
    one = {"valve.lap_leakage": 1e-9}, {"return_2_edge.lap_leakage": 2e-9}
    runs = [base.with_values(values) for values in (_of_every_edge(lap_leakage=1e-9), *one)]
    assert len({step_limits(lambda *_, run=run: [run])[part] for run in runs}) == 1
    equal: dict[str, Any] = _of_every_edge(lap=0.0, lap_leakage=0.0, flow_gain_ratio=1.0)
    assert base.with_values(equal).text() == base.text() != far.text()


@pytest.mark.parametrize("opening", [20e-6, 40e-6])
def test_bowed_valve_moves_a_free_piston_faster_in_proportion_to_its_opening(opening: float) -> None:
    values = {**FRICTIONLESS, **FREE, "leakage.internal_coefficient": 5e-9, "valve.edge_rounding": 1e-12}
    motion = free_motion([values | {"valve.gain_slope": 2e3}, values], [{}, {}], [opening] * 2, 0.4, 1e-4)
    bowed, straight = motion["velocity"][:, -200:].mean(axis=1)
    assert bowed / straight == pytest.approx(1.0 + 2e3 * opening, rel=1e-3)


NULL = 0.8e-6


@pytest.mark.parametrize("lap", [0.0, -2e-6])
def test_offset_of_the_null_is_a_shift_of_the_spool(lap: float) -> None:
    shifted = {"valve.lap": lap, "valve.null_offset": NULL}
    plain, spool = shifted | {"valve.null_offset": 1e-30}, [5e-6, 5e-6 - NULL, NULL]
    motion = free_motion([shifted, plain, shifted], [{}] * 3, spool, 0.2, 1e-4)
    for name in ("position", "pressure_1", "pressure_2"):
        np.testing.assert_allclose(motion[name][0], motion[name][1], rtol=1e-9, atol=1e-12)
    assert np.abs(motion["velocity"][2]).max() < 1e-15


def test_controller_asks_for_the_voltage_of_the_null() -> None:
    """Without a load, the spool ends where the null is: u = (x_n0 + r t)/k_v."""
    values = FREE | {"control.amplitude": 1e-9, "record.duration": 8.0, "valve.null_offset": NULL}
    batch = simulate_batch([machine(values | {"valve.null_drift": 0.2e-6}, LOOP)], [0.0])
    null, late = NULL + 0.2e-6 * batch.time, batch.time > 7.0
    np.testing.assert_allclose(batch.input_voltage[0, late], null[late] / SPOOL_GAIN, rtol=2e-3)
    np.testing.assert_allclose(batch.spool_position[0, late], null[late], rtol=2e-3)


def test_working_point_of_the_hydraulic_mode_is_seen_from_the_null() -> None:
    """A null behind the resting spool opens the valve as a spool ahead of its null does."""
    opening = 30e-6
    held = machine({"input.period": 2.0, "input.amplitude": opening / SPOOL_GAIN})
    runs = [held, machine({"input.amplitude": 1e-12, "valve.null_offset": -opening})]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    one, other = (hydraulic_mode(run, batch, k).damping_ratio for k, run in enumerate(runs))
    assert other == pytest.approx(one, rel=0.01)


WIDTH, AMPLITUDE = 0.2, 1.0


def _loop(period: float, **valve: float) -> tuple[np.ndarray, np.ndarray]:
    """Voltage and what the spool makes of it [V], over the second of two periods of a sine."""
    values = {"input.shape": "sine", "input.amplitude": AMPLITUDE, "input.period": period}
    values |= {"valve.natural_frequency": 500.0, "valve.damping_ratio": 1.0, "record.duration": 2 * period}
    run = RunParameters().with_values(values | {f"valve.{name}": value for name, value in valve.items()})
    n_step = round(period / run.record.step)
    spools = Spools([Drive.of(run)], run.record)
    spools.advance(0, n_step)
    voltage, stages = spools.advance(n_step, n_step)
    return voltage[:, 0], stages[:, 0, 0] / SPOOL_GAIN


@pytest.mark.parametrize("period", [2.0, 8.0])
def test_loop_closes_and_is_as_wide_as_configured_at_any_rate(period: float) -> None:
    """Up and down branch, a quarter of a period after the turns: ∓h/2 about the voltage; area h (2U − h)."""
    voltage, spool = _loop(period, hysteresis=WIDTH)
    n = voltage.size
    assert spool[0] == pytest.approx(-WIDTH / 2, abs=0.01 * 8 / period)
    assert spool[n // 2] == pytest.approx(WIDTH / 2, abs=0.01 * 8 / period)
    assert spool[-1] == pytest.approx(spool[0], abs=0.005)
    assert spool.max() == pytest.approx(AMPLITUDE - WIDTH / 2, rel=1e-3)
    area = abs(np.trapezoid(np.append(spool, spool[0]), np.append(voltage, voltage[0])))
    assert area == pytest.approx(2 * WIDTH * (AMPLITUDE - WIDTH / 2), rel=0.02 * 8 / period)


def test_hysteresis_as_wide_as_the_voltage_holds_the_spool_and_without_width_is_none() -> None:
    assert not _loop(2.0, hysteresis=2.01 * AMPLITUDE)[1].any()
    np.testing.assert_allclose(_loop(2.0, hysteresis=1e-12)[1], _loop(2.0)[1], atol=1e-11)
