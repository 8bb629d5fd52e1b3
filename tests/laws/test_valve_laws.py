"""Laws of the valve: flow, edges, null and hysteresis."""

import math
from typing import Any

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion

from hydrofdi.config import RunParameters
from hydrofdi.config.request import EDGES
from hydrofdi.physics.hydraulic_mode import valve_flow_pressure_coefficient
from hydrofdi.physics.valve import (
    chamber_1_orifice_drop,
    chamber_2_orifice_drop,
    clearance_conductance,
    control_flow,
    edge_flow,
    worn_opening,
)
from hydrofdi.quality.machine import hydraulic_mode, step_limits
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.inputs import Drive, Spools, largest_opening
from tests.machines import LOOP, RIG, machine


def _spool(step, ratio=0.7, duration=0.02, **limits):
    valve = {"valve.damping_ratio": ratio} | {f"valve.{name}": value for name, value in limits.items()}
    parameters = RunParameters().with_values(
        {"record.step": step, "record.sampling_frequency": round(1.0 / step), **valve}
    )
    n_step = round(duration / step)
    _, stages = Spools([Drive.of(parameters)], parameters.record).advance(0, n_step)
    return step * np.arange(n_step), stages[:, 0, 0]


def _second_order_step(time: np.ndarray, ratio: float) -> np.ndarray:
    omega, final = 2.0 * math.pi * 175.0, 22e-6 * 2.0
    damped = omega * math.sqrt(1.0 - ratio**2)
    wave = np.cos(damped * time) + ratio * omega / damped * np.sin(damped * time)
    return final * (1.0 - np.exp(-ratio * omega * time) * wave)


def test_spool_follows_a_voltage_step_like_a_second_order_lag_with_an_error_of_fourth_order() -> None:
    time, position = _spool(1e-4, 0.3)
    np.testing.assert_allclose(position, _second_order_step(time, 0.3), atol=1e-5 * 44e-6)
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        time, position = _spool(step)
        errors.append(np.abs(position - _second_order_step(time, 0.7)).max())
    assert np.all(np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 4.0) < 0.3)


def test_free_piston_runs_at_the_no_load_flow_over_its_area() -> None:
    parameters, opening = RunParameters(), 44e-6
    values = {"actuator.load_stiffness": 0.0, **FRICTIONLESS, "friction.viscous": 1.0}
    values |= {"leakage.internal_coefficient": 5e-9}  # damps the start
    motion = free_motion([values, values], [{}, {}], [opening, -opening], 0.4, 1e-4)
    valve, drop = parameters.valve, 0.5 * parameters.supply.pressure
    speed = (
        valve.flow_gain * valve.area_gradient * opening * math.sqrt(drop) / parameters.actuator.piston_area
    )
    np.testing.assert_allclose(motion["velocity"][:, -200:].mean(axis=1), [speed, -speed], rtol=1e-2)


def test_mirrored_opening_gives_mirrored_motion() -> None:
    motion = free_motion([{}, {}], [{}, {}], [44e-6, -44e-6], 0.3, 1e-4)
    np.testing.assert_allclose(motion["position"][0], -motion["position"][1], atol=1e-12)
    np.testing.assert_allclose(motion["pressure_1"][0], motion["pressure_2"][1], rtol=1e-9)


def test_limited_spool_stops_at_its_largest_opening_and_travels_at_its_largest_speed() -> None:
    _, position = _spool(1e-4, 0.3, largest_opening=30e-6)
    assert position.max() == 30e-6
    assert position[-1] == pytest.approx(30e-6, rel=0.05)
    time, position = _spool(1e-4, largest_speed=5e-3)
    cruising = (time > 2e-3) & (time < 6e-3)
    np.testing.assert_allclose(np.diff(position[cruising]), 5e-3 * 1e-4, rtol=1e-9)
    assert position[-1] == pytest.approx(44e-6, rel=0.02)


GAIN = (RunParameters().valve.flow_gain, RunParameters().valve.area_gradient)


@pytest.mark.parametrize("opening", [-44e-6, 0.0, 20e-6])
@pytest.mark.parametrize("pressure", [-1e6, 3e6, 18e6])
def test_critically_lapped_edges_are_the_orifices_of_the_paper(opening: float, pressure: float) -> None:
    supply, ret = 17.2e6, 0.2e6
    q_1 = edge_flow(opening, supply - pressure, *GAIN, 0.0, 0.0)
    q_1 -= edge_flow(-opening, pressure - ret, *GAIN, 0.0, 0.0)
    q_2 = edge_flow(opening, pressure - ret, *GAIN, 0.0, 0.0)
    q_2 -= edge_flow(-opening, supply - pressure, *GAIN, 0.0, 0.0)
    drop_1 = chamber_1_orifice_drop(opening, pressure, supply, ret)
    drop_2 = chamber_2_orifice_drop(opening, pressure, supply, ret)
    assert q_1 == pytest.approx(control_flow(opening, drop_1, *GAIN), rel=1e-12, abs=1e-20)
    assert q_2 == pytest.approx(control_flow(opening, drop_2, *GAIN), rel=1e-12, abs=1e-20)


def test_overlapped_valve_does_not_move_the_piston_within_its_dead_band() -> None:
    values = {"valve.lap": 5e-6, "actuator.load_stiffness": 0.0}
    motion = free_motion([values] * 2, [{}] * 2, [4.9e-6, 15e-6], 0.2, 1e-4)
    assert np.abs(motion["position"][0]).max() < 1e-9
    assert motion["position"][1, -1] > 1e-3


def test_underlap_damps_the_hydraulic_mode() -> None:
    """Both edges of a port stand open by x_0: K_c is twice that of one, and the decay rate β K_c/(2V)."""
    lap, beta, volume, seconds = 4e-6, 551e6, 280e-6, 1.0
    values = {**FRICTIONLESS, "actuator.load_stiffness": 0.0, "valve.lap": -lap}
    velocity = free_motion([values], [{"velocity": 1e-3}], [0.0], seconds, 2e-5)["velocity"][0]
    peaks = [np.abs(part).max() for part in np.split(velocity, 50)]
    coefficient = 2.0 * valve_flow_pressure_coefficient(lap, 8.6e6, *GAIN)
    rate = math.log(peaks[5] / peaks[45]) / (seconds * 40 / 50)
    assert rate == pytest.approx(beta * coefficient / (2.0 * volume), rel=0.02)


SHORT = RunParameters().with_values({"record.duration": 1.0, "input.period": 0.5})
LAPPED = {"valve.lap": -1e-6, "valve.lap_leakage": 2e-14}
FREE = {"actuator.load_stiffness": 0.0}


def _of_every_edge(**values: float) -> dict[str, float]:
    return {f"{edge}.{name}": value for edge in EDGES for name, value in values.items()}


def test_what_all_edges_have_of_their_own_is_what_the_valve_has() -> None:
    """Lap and clearance add up, gains multiply."""
    own = _of_every_edge(lap=-1e-6, lap_leakage=2e-14, flow_gain_ratio=0.5)
    gain = RunParameters().valve.flow_gain
    runs = [machine(own), machine(LAPPED | {"valve.flow_gain": 0.5 * gain})]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    np.testing.assert_array_equal(batch.chamber_1_pressure[0], batch.chamber_1_pressure[1])
    np.testing.assert_array_equal(batch.piston_position[0], batch.piston_position[1])


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


def test_valve_at_null_leaks_as_stated_with_both_ports_closed() -> None:
    """Closed ports hold each chamber where its two edges pass the same flow."""
    supply, ret = 17.2e6, 0.4e6
    own = clearance_conductance(5e-6, supply, ret)
    middle = 0.5 * (supply + ret)
    sides = [edge_flow(0.0, drop, 0.0292, 20.75e-3, 0.0, own) for drop in (supply - middle, middle - ret)]
    assert sides[0] == pytest.approx(sides[1])
    assert 2.0 * sides[0] == pytest.approx(5e-6)


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
    far = SHORT.with_values({"return_2_edge.lap": -3e-6, "supply_1_edge.lap": 5e-6})
    assert largest_opening(far) == pytest.approx(largest_opening(SHORT) + 3e-6)
    part, values = "leakage of the chambers", _of_every_edge(lap_leakage=1e-9)
    all_four, common, one = (
        step_limits(lambda *_, run=run: [run])[part]
        for run in map(
            SHORT.with_values, (values, {"valve.lap_leakage": 1e-9}, {"return_2_edge.lap_leakage": 2e-9})
        )
    )
    assert all_four == common == one


def test_edges_leave_the_identity_of_other_runs_alone() -> None:
    equal: dict[str, Any] = _of_every_edge(lap=0.0, lap_leakage=0.0, flow_gain_ratio=1.0)
    assert SHORT.with_values(equal).text() == SHORT.text()
    assert SHORT.with_values({"supply_1_edge.lap": 1e-6}).text() != SHORT.text()


@pytest.mark.parametrize("travel", [-20e-6, -1e-7, 0.0, 1e-6, 44e-6])
def test_rounded_edge_is_a_hyperbola_between_shut_and_open(travel: float) -> None:
    """y (y − s) = r²/4 with y > 0: y = s far open, 0 far shut."""
    opening = worn_opening(travel, 2e-6, 0.0)
    assert opening > max(travel, 0.0)
    assert opening * (opening - travel) == pytest.approx(1e-12, rel=1e-6)
    assert worn_opening(travel, 0.0, 0.0) == max(travel, 0.0)


def test_rounded_valve_at_its_null_is_one_with_an_underlap_of_half_the_radius() -> None:
    values = {"supply.droop": "first_order", "supply.droop_resistance": 4e10, "actuator.mass": 1e12}
    own = [{"valve.edge_rounding": 4e-6}, {"valve.lap": -2e-6, "valve.gain_slope": 1e-9}]
    motion = free_motion([values | each for each in own], [{}, {}], [0.0, 0.0], 1.0, 1e-4)
    rounded, lapped = motion["supply"][:, -1]
    assert rounded == pytest.approx(lapped, rel=1e-9)
    assert rounded < 17.1e6


def test_bowed_valve_moves_a_free_piston_faster_in_proportion_to_its_opening() -> None:
    slope = 2e3
    values = {**FRICTIONLESS, **FREE, "leakage.internal_coefficient": 5e-9, "valve.edge_rounding": 1e-12}
    for opening in (20e-6, 40e-6):
        own = [values | {"valve.gain_slope": slope}, values]
        motion = free_motion(own, [{}, {}], [opening] * 2, 0.4, 1e-4)
        bowed, straight = motion["velocity"][:, -200:].mean(axis=1)
        assert bowed / straight == pytest.approx(1.0 + slope * opening, rel=1e-3)


NULL = 0.8e-6
SPOOL_GAIN = RunParameters().valve.spool_gain


@pytest.mark.parametrize("lap", [0.0, -2e-6])
def test_offset_of_the_null_is_a_shift_of_the_spool(lap: float) -> None:
    motion = free_motion(
        [{"valve.lap": lap, "valve.null_offset": NULL}, {"valve.lap": lap, "valve.null_offset": 1e-30}],
        [{}, {}], [5e-6, 5e-6 - NULL], 0.2, 1e-4,
    )  # fmt: skip
    for name in ("position", "pressure_1", "pressure_2"):
        np.testing.assert_allclose(motion[name][0], motion[name][1], rtol=1e-9, atol=1e-12)
    still = free_motion([{"valve.lap": lap, "valve.null_offset": NULL}], [{}], [NULL], 0.1, 1e-4)
    assert np.ptp(still["pressure_1"]) == 0.0
    assert np.abs(still["velocity"]).max() < 1e-15


def test_null_that_drifts_passes_the_spool_that_it_was_drifting_to() -> None:
    """The piston turns where x_n0 + r t = x_v: the edges change their sides."""
    values = {"valve.null_offset": 1e-6, "valve.null_drift": 1e-5, "actuator.load_stiffness": 0.0}
    motion = free_motion([values | {"leakage.internal_coefficient": 5e-9}], [{}], [3e-6], 0.4, 1e-4)
    turn = 1e-4 * np.argmax(motion["position"][0])
    assert turn == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("base", [RIG, LOOP], ids=["open", "closed"])
def test_spool_position_counts_from_the_zero_of_the_spool(base: dict[str, Any]) -> None:
    """In open loop the spool does not know of the null; in closed loop the controller moves it there."""
    runs = [machine({}, base), machine({"valve.null_offset": NULL}, base)]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    plain, shifted = batch.spool_position
    assert np.ptp(batch.piston_position[0] - batch.piston_position[1]) > 0.0
    if base is RIG:
        np.testing.assert_array_equal(shifted, plain)
    else:
        assert np.mean(shifted - plain) == pytest.approx(NULL, rel=0.3)


def test_controller_asks_for_the_voltage_of_the_null() -> None:
    """Without a load, the spool ends where the null is: u = (x_n0 + r t)/k_v."""
    drift = 0.2e-6
    values = {
        "control.amplitude": 1e-9, "actuator.load_stiffness": 0.0, "record.duration": 8.0,
        "valve.null_offset": NULL, "valve.null_drift": drift,
    }  # fmt: skip
    run = machine(values, LOOP)
    batch = simulate_batch([run], [0.0])
    settled = batch.time > 7.0
    expected = (NULL + drift * batch.time) / SPOOL_GAIN
    np.testing.assert_allclose(batch.input_voltage[0, settled], expected[settled], rtol=2e-3)


def test_working_point_of_the_hydraulic_mode_is_seen_from_the_null() -> None:
    """A null behind the resting spool opens the valve as a spool ahead of its null does."""
    opening = 30e-6
    held = machine({"input.period": 2.0, "input.amplitude": opening / SPOOL_GAIN})
    shifted = machine({"input.amplitude": 1e-12, "valve.null_offset": -opening})
    runs = [held, shifted]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    one, other = (hydraulic_mode(run, batch, k).damping_ratio for k, run in enumerate(runs))
    assert other == pytest.approx(one, rel=0.01)


WIDTH, AMPLITUDE = 0.2, 1.0
SINE: dict[str, Any] = {"input.shape": "sine", "input.amplitude": AMPLITUDE}
QUICK_SPOOL = {"valve.natural_frequency": 500.0, "valve.damping_ratio": 1.0}


def _loop(period: float, **valve: float) -> tuple[np.ndarray, np.ndarray]:
    """Voltage and what the spool makes of it [V], over the second of two periods."""
    values = SINE | QUICK_SPOOL | {f"valve.{name}": value for name, value in valve.items()}
    run = RunParameters().with_values(values | {"input.period": period, "record.duration": 2 * period})
    n_step = round(period / run.record.step)
    spools = Spools([Drive.of(run)], run.record)
    for first in (0, n_step):
        voltage, stages = spools.advance(first, n_step)
        loop = voltage[:, 0].copy(), stages[:, 0, 0] / SPOOL_GAIN
    return loop


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


def test_closed_loop_swings_about_a_position_that_it_would_reach() -> None:
    """An integral part and a play cannot agree: the voltage keeps crossing the whole width."""
    values = {"control.integral_gain": 400.0, "input.period": 40.0, "record.duration": 10.0}
    runs = [machine(values | {"valve.hysteresis": width}, LOOP) for width in (1e-30, WIDTH)]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    late = np.ptp(batch.input_voltage[:, batch.time > 6.0], axis=1)
    assert late[0] < 0.1 * WIDTH
    assert late[1] > WIDTH
