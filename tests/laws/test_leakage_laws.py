"""Laws of leakage, seen through the simulation."""

import numpy as np
import pytest
from free_motion import FREE, HELD, free_motion

from hydrofdi.physics.cylinder import internal_leakage_flow, laminar_leakage_flow
from hydrofdi.simulation.batch import leakage_signal, simulate_batch
from hydrofdi.simulation.calibration import solve_leakage_coefficients
from tests.machines import GAP, HOSES, LOOP, machine

VOLUME, MODULUS = 280e-6, 551e6
SHORT = {"record.duration": 2.0, "input.period": 1.0}


@pytest.mark.parametrize(("coefficient", "modulus"), [(1e-10, 551e6), (1e-9, 827e6)])
def test_shut_valve_lets_the_root_of_the_pressure_difference_fall_linearly_to_zero(coefficient, modulus):
    end, n_step = VOLUME * np.sqrt(4e6) / (modulus * coefficient), 2000
    values = HELD | {"leakage.internal_coefficient": coefficient, "fluid.bulk_modulus": modulus}
    start = {"pressure_1": 10.6e6, "pressure_2": 6.6e6}
    motion = free_motion([values], [start], [0.0], 0.95 * end, 0.95 * end / n_step)
    root = np.sqrt(motion["pressure_1"] - motion["pressure_2"])[0]
    np.testing.assert_allclose(root, np.sqrt(4e6) * (1.0 - 0.95 * np.arange(n_step) / n_step), rtol=1e-7)


@pytest.mark.parametrize(
    ("base", "values"),
    [
        (GAP, {"leakage.laminar_reference": 4e6}),
        (HOSES, {"leakage.blending_pressure": 4e6, "actuator.hose_inertance": 1e30}),
    ],
    ids=["laminar", "blended"],
)
def test_a_small_pressure_difference_across_a_gap_decays_exponentially(base, values):
    """Of a blended law far below its blending pressure: there it does not chatter as a root does."""
    start = {"pressure_1": 8.602e6, "pressure_2": 8.6e6}
    motion = free_motion(
        [HELD | values | {"leakage.internal_coefficient": 1e-9}], [start], [0.0], 0.2, 1e-4, base
    )
    rate = 2.0 * MODULUS * 1e-9 / (VOLUME * np.sqrt(4e6))
    difference = (motion["pressure_1"] - motion["pressure_2"])[0]
    np.testing.assert_allclose(difference, 2e3 * np.exp(-rate * 1e-4 * np.arange(2000)), rtol=1e-6)


@pytest.mark.parametrize(("key", "leaks"), [("", [True, True]), ("_2", [False, True])])
def test_shut_valve_lets_an_external_leak_empty_its_chambers_exponentially(key, leaks):
    values = HELD | {f"leakage.external_coefficient{key}": 2e-12}
    motion = free_motion([values], [{"pressure_1": 9e6, "pressure_2": 5e6}], [0.0], 0.2, 1e-4)
    decay = np.exp(-MODULUS * 2e-12 / VOLUME * 1e-4 * np.arange(2000))
    for chamber, start, is_leaking in ((1, 9e6, leaks[0]), (2, 5e6, leaks[1])):
        expected = start * decay if is_leaking else np.full(2000, start)
        np.testing.assert_allclose(motion[f"pressure_{chamber}"][0], expected, rtol=1e-6)


@pytest.mark.parametrize("onset", ["step", "ramp"])
def test_leak_that_sets_in_leaves_the_time_before_untouched_and_grows_over_its_duration(onset) -> None:
    times = {"leakage.onset": onset, "leakage.onset_time": 0.5, "leakage.onset_duration": 1.0}
    batch = simulate_batch([machine(SHORT | times, GAP)] * 2, [0.0, 5e-9])
    sealed, leaking = batch.chamber_1_pressure
    before = batch.time <= 0.5
    np.testing.assert_array_equal(leaking[before], sealed[before])
    assert np.abs(leaking - sealed)[~before].max() > 1e5
    drop = (batch.chamber_1_pressure - batch.chamber_2_pressure)[1, 1:]
    share, time = batch.internal_leakage_flow[1, 1:] / laminar_leakage_flow(drop, 5e-9, 10e6), batch.time[1:]
    expected = time >= 0.5 if onset == "step" else np.clip(time - 0.5, 0.0, 1.0)
    np.testing.assert_allclose(share, expected, atol=1e-5)


@pytest.mark.parametrize(
    ("base", "values"),
    [(GAP, {}), (HOSES, {}), (LOOP, {"leakage.scored_width": 8e-3})],
    ids=["laminar", "blended", "scored"],
)
def test_leakage_flow_is_solved_under_the_law_that_was_chosen(base, values) -> None:
    run = machine(SHORT | values | {"leakage.internal_flow": 2e-6}, base)
    (found,) = solve_leakage_coefficients([run])
    flow = simulate_batch([run], [found.coefficient]).mean_internal_leakage_flow[0]
    assert flow == pytest.approx(2e-6, rel=1e-6)


@pytest.mark.parametrize("base", [LOOP, GAP, HOSES], ids=["orifice", "laminar", "blended"])
def test_piston_that_drags_oil_leaks_as_at_a_larger_pressure_difference(base) -> None:
    run, plain = (machine(SHORT | FREE | {"leakage.drag": drag}, base) for drag in (4e6, 0.0))
    batch = simulate_batch([run], [2e-9])
    difference = batch.chamber_1_pressure - batch.chamber_2_pressure + 4e6 * batch.piston_velocity
    none = np.zeros_like(difference)
    expected = leakage_signal([plain], [2e-9], batch.time, difference, none, none)
    np.testing.assert_allclose(batch.internal_leakage_flow, expected, rtol=1e-9, atol=1e-15)
    assert np.abs(4e6 * batch.piston_velocity).max() > 1e5


def test_scored_bore_leaks_over_its_part_of_the_stroke_alone() -> None:
    run = machine(SHORT | {"leakage.scored_centre": 4e-3, "leakage.scored_width": 4e-3}, LOOP)
    batch = simulate_batch([run], [2e-9])
    distance, flow = np.abs(batch.piston_position - 4e-3), batch.internal_leakage_flow
    whole = internal_leakage_flow(batch.chamber_1_pressure - batch.chamber_2_pressure, 2e-9)
    assert distance.min() < 1e-3
    np.testing.assert_allclose(flow[distance < 1e-3], whole[distance < 1e-3], rtol=0.01)
    assert np.abs(flow[distance > 5e-3]).max() < 1e-3 * np.abs(whole).max()
