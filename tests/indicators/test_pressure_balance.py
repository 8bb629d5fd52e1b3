"""Pressure balance: K_i of simulated runs comes out without a position, and without the second pressure."""

import numpy as np
import pytest

from indicators.observed import simulated
from indicators.signals import P1, P2, U, assert_rows_stand_alone, batch, measured

LEAKS = np.array([0.0, 0.0, 0.0, 3e-10, 1e-9, 3e-9])
MODULI = [551e6, 689e6, 827e6, 551e6, 689e6, 551e6]


@pytest.fixture(scope="module")
def runs():
    """Healthy at three EBM, and three that leak; 10 s, without noise and position."""
    return without_position(simulated("record.duration=10 s", leaks=LEAKS, moduli=MODULI))


@pytest.mark.parametrize(("chambers", "tolerance", "error"), [("both", 0.05, 1e-10), (1, 0.15, 2e-10)])
def test_leakage_comes_out_at_any_bulk_modulus(runs, chambers, tolerance, error):
    values, _ = measured(runs, "pressure_balance", chambers=chambers)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=tolerance, atol=error)
    assert (values["leakage_error"] < 0.03 / 60e3).all()


def test_the_softer_spring_is_the_longer_way(runs):
    """Twice the flow, areas, spring and volume are twice the leak."""
    one, _ = measured(runs, "pressure_balance", error="30 mm^3")
    twice = {
        "flow_gain": 2 * 0.0292, "piston_area": 2 * 633e-6, "load_stiffness": 2 * 150e3,
        "chamber_volume": 560e-6, "clearance_deviation": 2e-14, "error": "60 mm^3",
    }  # fmt: skip
    two, _ = measured(runs, "pressure_balance", **twice)
    np.testing.assert_allclose(
        two["internal_coefficient"], 2.0 * one["internal_coefficient"], rtol=1e-6, atol=1e-15
    )


def test_one_pressure_is_enough_and_a_record_stands_alone(runs):
    alone = batch({P1: runs[P1], U: runs[U]})
    assert "has no chamber_2_pressure" in measured(alone, "pressure_balance")[1][0]
    assert_rows_stand_alone(alone, "pressure_balance", chambers=1)
    assert_rows_stand_alone(runs, "pressure_balance")


@pytest.mark.parametrize(("drive_period", "error"), [(2.0, 2e-10), (None, 2e-10)])
def test_one_pressure_alone_is_enough_where_the_drive_is_a_square_wave(runs, drive_period, error):
    alone = batch({P1: runs[P1]}, drive_period=drive_period)
    options = {"chambers": 1, "spool": "square"}
    values, _ = measured(alone, "pressure_balance", **options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.15, atol=error)
    falling_first, _ = measured(alone.window(500), "pressure_balance", **options)
    np.testing.assert_allclose(falling_first["internal_coefficient"], LEAKS, rtol=0.15, atol=error)
    assert_rows_stand_alone(alone, "pressure_balance", **options)


def test_jumps_of_a_load_in_closed_loop_are_weighed_down():
    leaks = np.array([0.0, 3e-10])
    settings = (
        "record.duration=20 s", "control.law=pi", "input.shape=steps", "input.period=1 s",
        "load.random_force=1 kN", "load.random_period=0.5 s",
    )  # fmt: skip
    shown = without_position(simulated(*settings, leaks=leaks, moduli=[551e6] * 2))
    robust, plain = (
        np.abs(measured(shown, "pressure_balance", robust=way)[0]["internal_coefficient"] - leaks).max()
        for way in (True, False)
    )
    assert robust < 1e-10
    assert plain > 3.0 * robust


def test_ringing_is_waited_for(runs):
    """Pressures ring after a step and the position does not; this must not count as leakage."""
    error = [
        np.abs(measured(runs, "pressure_balance", **options)[0]["internal_coefficient"] - LEAKS).max()
        for options in ({}, {"settling": 0.0, "half_window": 8})
    ]
    assert error[0] < 0.2 * error[1]


def without_position(records):
    return batch({channel: records[channel] for channel in (P1, P2, U)})
