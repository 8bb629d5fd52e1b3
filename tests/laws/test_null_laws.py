"""The null of the valve: where its ports are centred, and how that drifts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from free_motion import free_motion

from hydrofdi.config import RunParameters
from hydrofdi.quality.measures import hydraulic_mode
from hydrofdi.simulation.batch import simulate_batch

NULL = 0.8e-6
GAIN = RunParameters().valve.spool_gain
SHORT = RunParameters().with_values({"record.duration": 1.0, "input.period": 0.5})
CLOSED: dict[str, Any] = {"control.law": "pi", "control.amplitude": 5e-3}


@pytest.mark.parametrize("lap", [0.0, 2e-6, -2e-6])
def test_offset_of_the_null_is_a_shift_of_the_spool(lap: float) -> None:
    motion = free_motion(
        [{"valve.lap": lap, "valve.null_offset": NULL}, {"valve.lap": lap, "valve.null_offset": 1e-30}],
        [{}, {}], [5e-6, 5e-6 - NULL], 0.2, 1e-4,
    )  # fmt: skip
    for name in ("position", "pressure_1", "pressure_2"):
        np.testing.assert_allclose(motion[name][0], motion[name][1], rtol=1e-9, atol=1e-12)


def test_spool_at_its_null_lets_nothing_move() -> None:
    motion = free_motion([{"valve.null_offset": NULL}], [{}], [NULL], 0.1, 1e-4)
    assert np.ptp(motion["pressure_1"]) == 0.0
    assert not motion["velocity"].any()


def test_null_that_drifts_passes_the_spool_that_it_was_drifting_to() -> None:
    """The piston turns where x_n0 + r t = x_v: the edges change their sides."""
    values = {"valve.null_offset": 1e-6, "valve.null_drift": 1e-5, "actuator.load_stiffness": 0.0}
    motion = free_motion([values | {"leakage.internal_coefficient": 5e-9}], [{}], [3e-6], 0.4, 1e-4)
    turn = 1e-4 * np.argmax(motion["position"][0])
    assert turn == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("loop", [{}, CLOSED], ids=["open", "closed"])
def test_spool_position_counts_from_the_zero_of_the_spool(loop: dict[str, Any]) -> None:
    """In open loop the spool does not know of the null; in closed loop the controller moves it there."""
    runs = [SHORT.with_values(loop), SHORT.with_values(loop | {"valve.null_offset": NULL})]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    plain, shifted = batch.spool_position
    assert np.ptp(batch.piston_position[0] - batch.piston_position[1]) > 0.0
    if not loop:
        np.testing.assert_array_equal(shifted, plain)
    else:
        assert np.mean(shifted - plain) == pytest.approx(NULL, rel=0.3)


def test_controller_asks_for_the_voltage_of_the_null() -> None:
    """Without a load, the spool ends where the null is: u = (x_n0 + r t)/k_v."""
    drift = 0.2e-6
    run = SHORT.with_values({
        **CLOSED, "control.amplitude": 1e-9, "actuator.load_stiffness": 0.0, "record.duration": 8.0,
        "valve.null_offset": NULL, "valve.null_drift": drift,
    })  # fmt: skip
    batch = simulate_batch([run], [0.0])
    settled = batch.time > 7.0
    expected = (NULL + drift * batch.time) / GAIN
    np.testing.assert_allclose(batch.input_voltage[0, settled], expected[settled], rtol=2e-3)


def test_working_point_of_the_hydraulic_mode_is_seen_from_the_null() -> None:
    """A null behind the resting spool opens the valve as a spool ahead of its null does."""
    opening = 30e-6
    held = SHORT.with_values({"input.period": 2.0, "input.amplitude": opening / GAIN})
    shifted = SHORT.with_values({"input.amplitude": 1e-12, "valve.null_offset": -opening})
    runs = [held, shifted]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    one, other = (hydraulic_mode(run, batch, k).damping_ratio for k, run in enumerate(runs))
    assert other == pytest.approx(one, rel=0.01)
