"""Laws of leakage, seen through the simulation."""

import numpy as np
import pytest
from free_motion import free_motion
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.api.sweeps import calibrate
from hydrofdi.config import load_experiment
from hydrofdi.physics.cylinder import blended_leakage_flow, internal_leakage_flow, laminar_leakage_flow
from hydrofdi.physics.hydraulic_mode import blended_conductance, laminar_conductance
from hydrofdi.simulation.batch import leakage_signal, simulate_batch
from hydrofdi.simulation.calibration import solve_leakage_coefficients
from tests.machines import GAP, HOSES, LOOP, RIG, machine

HELD = {"actuator.mass": 1e18}
"""A piston so heavy that it does not move."""


@pytest.mark.parametrize(("coefficient", "bulk_modulus"), [(1e-10, 551e6), (1e-9, 827e6)])
def test_shut_valve_lets_the_root_of_the_pressure_difference_fall_linearly_to_zero(coefficient, bulk_modulus):
    difference, volume = 4e6, 280e-6
    end = volume * np.sqrt(difference) / (bulk_modulus * coefficient)
    values = HELD | {"leakage.internal_coefficient": coefficient, "fluid.bulk_modulus": bulk_modulus}
    start = {"pressure_1": 8.6e6 + difference / 2, "pressure_2": 8.6e6 - difference / 2}
    n_step = 2000
    motion = free_motion([values], [start], [0.0], 0.95 * end, 0.95 * end / n_step)
    root = np.sqrt(motion["pressure_1"] - motion["pressure_2"])[0]
    time = np.arange(n_step) * 0.95 * end / n_step
    np.testing.assert_allclose(root, np.sqrt(difference) * (1.0 - time / end), rtol=1e-7)


@pytest.mark.parametrize(("key", "leaks"), [("", [True, True]), ("_2", [False, True])])
def test_shut_valve_lets_an_external_leak_empty_its_chambers_exponentially(key, leaks):
    values = HELD | {f"leakage.external_coefficient{key}": 2e-12}
    motion = free_motion([values], [{"pressure_1": 9e6, "pressure_2": 5e6}], [0.0], 0.2, 1e-4)
    decay = np.exp(-551e6 * 2e-12 / 280e-6 * 1e-4 * np.arange(2000))
    for chamber, start, is_leaking in ((1, 9e6, leaks[0]), (2, 5e6, leaks[1])):
        expected = start * decay if is_leaking else np.full(2000, start)
        np.testing.assert_allclose(motion[f"pressure_{chamber}"][0], expected, rtol=1e-6)


differences = st.floats(min_value=-20e6, max_value=20e6)
SHORT = {"record.duration": 2.0, "input.period": 1.0}


def test_laminar_gap_lets_the_pressure_difference_decay_exponentially() -> None:
    coefficient, reference = 1e-9, 4e6
    values = HELD | {"leakage.internal_coefficient": coefficient, "leakage.laminar_reference": reference}
    start = {"pressure_1": 11e6, "pressure_2": 7e6}
    motion = free_motion([values], [start], [0.0], 0.2, 1e-4, GAP)
    rate = 2.0 * 551e6 * coefficient / (280e-6 * np.sqrt(reference))
    expected = 4e6 * np.exp(-rate * 1e-4 * np.arange(2000))
    np.testing.assert_allclose((motion["pressure_1"] - motion["pressure_2"])[0], expected, rtol=1e-7)


@given(differences)
def test_blended_law_is_odd_and_never_above_the_orifice(difference: float) -> None:
    flow = blended_leakage_flow(difference, 1e-9, 1e3)
    assert flow == -blended_leakage_flow(-difference, 1e-9, 1e3)
    assert abs(flow) <= abs(internal_leakage_flow(difference, 1e-9)) * (1.0 + 1e-12)
    assert blended_leakage_flow(1e6, 1e-9, 1e3) == pytest.approx(internal_leakage_flow(1e6, 1e-9), rel=1e-6)
    assert blended_leakage_flow(1.0, 1e-9, 1e3) == pytest.approx(1e-9 * 1.0 / np.sqrt(1e3), rel=1e-6, abs=0.0)


@given(st.floats(min_value=-5e3, max_value=5e3))
def test_conductances_are_the_slopes_of_their_laws(difference: float) -> None:
    ends = difference + np.array([-0.1, 0.1])
    for law, slope in (
        (blended_leakage_flow(ends, 1e-9, 1e3), blended_conductance(difference, 1e-9, 1e3)),
        (laminar_leakage_flow(ends, 1e-9, 1e3), laminar_conductance(1e-9, 1e3)),
    ):
        assert np.diff(law)[0] / 0.2 == pytest.approx(slope, rel=1e-5, abs=0.0)


def test_blended_law_ends_without_the_chatter_of_the_root() -> None:
    """Past the end of the decay the orifice overshoots from step to step; the blended law does not."""
    last = {}
    for law, base in (("orifice", RIG), ("blended", HOSES)):
        values = HELD | {"leakage.internal_coefficient": 1e-8, "actuator.hose_inertance": 1e30}
        start = {"pressure_1": 8.7e6, "pressure_2": 8.5e6}
        motion = free_motion([values], [start], [0.0], 0.2, 1e-4, base)
        last[law] = np.abs(motion["pressure_1"] - motion["pressure_2"])[0, -10:].max()
    assert last["blended"] < 1e-3 < last["orifice"]


def test_leak_that_sets_in_leaves_the_time_before_untouched() -> None:
    late = machine(SHORT | {"leakage.onset_time": 1.0}, GAP)
    sealed, leaking = (simulate_batch([late], [coefficient]) for coefficient in (0.0, 5e-9))
    before = sealed.time < 1.0
    np.testing.assert_array_equal(leaking.chamber_1_pressure[0, before], sealed.chamber_1_pressure[0, before])
    assert np.all(leaking.internal_leakage_flow[0, before] == 0.0)
    assert np.abs(leaking.internal_leakage_flow[0, ~before]).mean() > 1e-6


def test_step_onset_leaks_at_once_and_ramp_over_its_duration() -> None:
    share = {}
    for onset in ("step", "ramp"):
        times = {"leakage.onset": onset, "leakage.onset_time": 0.5, "leakage.onset_duration": 1.0}
        trajectory = simulate_batch([machine(SHORT | times, GAP)], [5e-9])
        difference = (trajectory.chamber_1_pressure - trajectory.chamber_2_pressure)[0, 1:]
        share[onset] = trajectory.internal_leakage_flow[0, 1:] / laminar_leakage_flow(difference, 5e-9, 10e6)
        time = trajectory.time[1:]
    np.testing.assert_allclose(share["step"], time >= 0.5, atol=1e-5)
    np.testing.assert_allclose(share["ramp"], np.clip(time - 0.5, 0.0, 1.0), atol=1e-9)


@pytest.mark.parametrize("base", [GAP, HOSES], ids=["laminar", "blended"])
def test_leakage_flow_is_solved_under_the_law_that_was_chosen(base) -> None:
    experiment = load_experiment(settings=[f"{name}={value}" for name, value in (base | SHORT).items()])
    (target,) = calibrate(experiment, flows=[1e-5])
    trajectory = simulate_batch([machine(SHORT, base)], [target["coefficient"]])
    assert trajectory.mean_internal_leakage_flow[0] == pytest.approx(1e-5, rel=1e-6)


MOVING = {"actuator.load_stiffness": 0.0, "leakage.internal_coefficient": 2e-9}


@pytest.mark.parametrize("base", [LOOP, GAP, HOSES], ids=["orifice", "laminar", "blended"])
def test_piston_that_drags_oil_leaks_as_at_a_larger_pressure_difference(base) -> None:
    run, plain = (machine(SHORT | MOVING | {"leakage.drag": drag}, base) for drag in (4e6, 0.0))
    batch = simulate_batch([run], [2e-9])
    difference = batch.chamber_1_pressure - batch.chamber_2_pressure + 4e6 * batch.piston_velocity
    none = np.zeros_like(difference)
    expected = leakage_signal([plain], [2e-9], batch.time, difference, none, none)
    np.testing.assert_allclose(batch.internal_leakage_flow, expected, rtol=1e-9, atol=1e-15)
    assert np.abs(4e6 * batch.piston_velocity).max() > 1e5


def test_scored_bore_leaks_over_its_part_of_the_stroke_alone() -> None:
    run = machine(SHORT | {"leakage.scored_centre": 4e-3, "leakage.scored_width": 4e-3}, LOOP)
    batch = simulate_batch([run], [2e-9])
    position, flow = batch.piston_position, batch.internal_leakage_flow
    whole = internal_leakage_flow(batch.chamber_1_pressure - batch.chamber_2_pressure, 2e-9)
    middle, far = np.abs(position - 4e-3) < 1e-3, np.abs(position - 4e-3) > 5e-3
    assert middle.any()
    assert far.any()
    np.testing.assert_allclose(flow[middle], whole[middle], rtol=0.01)
    assert np.abs(flow[far]).max() < 1e-3 * np.abs(whole).max()


def test_scored_bore_is_calibrated_to_its_mean_flow() -> None:
    run = machine(SHORT | {"leakage.scored_width": 8e-3, "leakage.internal_flow": 2e-6}, LOOP)
    (found,) = solve_leakage_coefficients([run])
    assert simulate_batch([run], [found.coefficient]).mean_internal_leakage_flow[0] == pytest.approx(2e-6)
