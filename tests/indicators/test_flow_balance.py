"""Balances of flow and of pressure: K_i and β of simulated runs come out."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.physics.cylinder import scored_share
from hydrofdi.records import Channel
from indicators.signals import KNOWN as ALL_KNOWN
from indicators.signals import P1, P2, XV, U, X, assert_rows_stand_alone, batch, measured, noisy, simulated
from tests.machines import GAP, LOOP, RIG, settings_of

LEAKS = np.array([0.0, 0.0, 0.0, 1e-9, 5e-9, 1.3e-8])
MODULI = np.array([551e6, 689e6, 827e6, 551e6, 689e6, 551e6])
KNOWN = ALL_KNOWN | {"bulk_modulus_deviation": 10.0}


@pytest.fixture(scope="module")
def runs():
    """Healthy at three EBM, and three that leak; 6 s, without noise."""
    return simulated("record.duration=6 s", leaks=LEAKS, moduli=MODULI)


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"half_window": 6}, {"least_opening": 0.0}])
def test_leakage_and_bulk_modulus_of_a_known_actuator_come_out(runs, options):
    values, _ = measured(runs, "flow_balance", **KNOWN | {"half_window": 8} | options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=1e-3, atol=1e-13)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=1e-3)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)
    np.testing.assert_allclose(values["cross_port_leakage"], values["leakage"], rtol=1e-12)
    mean = LEAKS * np.sqrt(np.abs(runs[P1] - runs[P2])).mean(axis=1)
    np.testing.assert_allclose(values["mean_leakage"], mean, rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize(("options", "tolerance"), [({}, 0.01), ({"chambers": 1}, 0.06)])
def test_leakage_and_bulk_modulus_come_out_of_an_uncertain_actuator_too(runs, options, tolerance):
    values, _ = measured(runs, "flow_balance", **options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=tolerance, atol=1e-12)
    np.testing.assert_allclose(values["bulk_modulus"][:3], MODULI[:3], rtol=tolerance)


def test_an_actuator_seen_from_its_other_side_leaks_the_same(runs):
    mirrored = {P1: runs[P2], P2: runs[P1], X: -runs[X], XV: -runs[XV], U: -runs[U]}
    one, _ = measured(runs, "flow_balance")
    other, _ = measured(replace(runs, channels=mirrored), "flow_balance")
    for name in ("internal_coefficient", "cross_port_leakage", "bulk_modulus", "lap", "flow_gain"):
        np.testing.assert_allclose(other[name], one[name], rtol=1e-6, atol=1e-16, err_msg=name)
    np.testing.assert_allclose(other["offset"], -one["offset"], rtol=1e-6, atol=1e-12)


def test_a_valve_and_sensors_that_are_not_nominal_are_found_and_hide_no_leak():
    leaks = np.array([0.0, 1e-10, 1e-9])
    shown = simulated(
        *settings_of(RIG), "record.duration=6 s", "valve.lap=-0.5 um", "valve.lap_leakage=2e-14 m^3/(s*Pa)",
        "valve.flow_gain=0.0298 m^1.5/kg^0.5", "supply.pressure=16.6 MPa", leaks=leaks, moduli=[689e6] * 3,
    )  # fmt: skip
    for channel, error in ((P1, 30e3), (P2, -20e3), (XV, -0.4e-6)):
        shown.channels[channel] = shown[channel] + error
    values, _ = measured(shown, "flow_balance")
    np.testing.assert_allclose(values["internal_coefficient"], leaks, atol=3e-11)
    np.testing.assert_allclose(values["supply_pressure"], 16.6e6, rtol=2e-3)
    np.testing.assert_allclose(values["bulk_modulus"], 689e6, rtol=0.02)
    alike, _ = measured(shown, "flow_balance", edge_gain_deviation=0.0, edge_lap_deviation=0.0)
    np.testing.assert_allclose(alike["offset"], -0.4e-6, rtol=0.1)
    plain, _ = measured(shown, "flow_balance", **KNOWN)
    assert (np.abs(plain["internal_coefficient"] - leaks) > 3e-10).all()


def test_in_closed_loop_lap_is_found_and_samples_near_the_null_would_mislead():
    leaks = np.array([0.0, 3e-10])
    shown = simulated(
        *settings_of(LOOP), "record.duration=10 s", "control.amplitude=20 mm", "input.shape=steps",
        "input.period=1 s", "valve.lap=0.8 um", leaks=leaks, moduli=[551e6] * 2,
    )  # fmt: skip
    gated, kept = (
        measured(shown, "flow_balance", spool="command", least_opening=size)[0] for size in (2e-6, 0.0)
    )
    np.testing.assert_allclose(gated["lap"], 0.8e-6, rtol=0.1)
    error, misled = (np.abs(values["internal_coefficient"] - leaks).max() for values in (gated, kept))
    assert error < 2e-11
    assert misled > 3.0 * error


def test_a_laminar_leak_is_seen_by_the_flow_past_piston_and_valve():
    laminar = *settings_of(GAP), "record.duration=6 s", "leakage.laminar_reference=10 MPa"
    values, _ = measured(simulated(*laminar, leaks=[1e-9], moduli=[551e6]), "flow_balance")
    np.testing.assert_allclose(values["cross_port_leakage"], 1e-9 * np.sqrt(10e6) * 0.8, rtol=0.2)


@pytest.mark.parametrize("name", ["flow_balance", "weak_rls"])
@pytest.mark.parametrize("chambers", ["both", 1])
def test_the_mean_flow_of_a_score_in_a_part_of_the_stroke_comes_out(name, chambers):
    centre, width = 2e-3, 10e-3
    shown = simulated(
        *settings_of(LOOP), "record.duration=20 s", "control.amplitude=20 mm", "input.shape=steps",
        "input.period=1 s", f"leakage.scored_width={width}", f"leakage.scored_centre={centre}",
        leaks=[0.0, 1e-9, 5e-9], moduli=[551e6] * 3,
    )  # fmt: skip
    flow = [0.0, 1e-9, 5e-9] * np.mean(
        scored_share(shown[X], centre, width) * np.sqrt(np.abs(shown[P1] - shown[P2])), axis=1
    )
    values, _ = measured(shown, name, spool="command", chambers=chambers)
    np.testing.assert_allclose(values["mean_leakage"], flow, rtol=0.15, atol=3e-7)
    assert (np.abs(values["mean_leakage"] - flow) < 2.0 * values["mean_leakage_error"]).all()


def test_a_wrong_area_or_volume_scales_what_it_should(runs):
    twice = {"piston_area": 2 * 633e-6, "flow_gain": 2 * 0.0292, "chamber_volume": 560e-6}
    values, _ = measured(runs, "flow_balance", **KNOWN | twice)
    np.testing.assert_allclose(values["internal_coefficient"], 2 * LEAKS, rtol=1e-3, atol=1e-13)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=1e-3)


@pytest.mark.parametrize("row", [0, 3])
def test_the_stated_deviations_are_those_of_repeats(runs, row):
    values, _ = measured(
        noisy(runs, [row] * 200, seed=row), "flow_balance", half_window=8, error="5 mm^3", **KNOWN
    )
    for name, truth in (("internal_coefficient", LEAKS[row]), ("bulk_modulus", MODULI[row])):
        stated = values[f"{name}_error"].mean()
        assert 0.4 * stated < values[name].std() < 1.5 * stated
        assert abs(values[name].mean() - truth) < 2.0 * stated


def test_the_supply_may_be_measured_nominal_or_the_sum_of_the_pressures(runs):
    measured_supply = replace(
        runs, channels={**runs.channels, Channel.SUPPLY_PRESSURE: np.full(runs[P1].shape, 17.2e6)}
    )
    no_scale = replace(measured_supply, relative=frozenset({Channel.SUPPLY_PRESSURE}))
    options = KNOWN | {"supply_pressure": "16 MPa"}
    wrong, _ = measured(measured_supply, "flow_balance", **options)
    right, _ = measured(measured_supply, "flow_balance", **options | {"supply": "auto"})
    total, _ = measured(no_scale, "flow_balance", **options | {"supply": "auto"})
    assert (total["supply_pressure"] != 17.2e6).all()
    error = [np.abs(v["internal_coefficient"] - LEAKS).max() for v in (wrong, right, total)]
    assert error[1] < 1e-11
    assert 1e-11 < error[2] < 2e-10 < error[0]
    one, _ = measured(runs, "flow_balance", chambers=1, supply="sum")
    np.testing.assert_allclose(one["supply_pressure"], 17.2e6, rtol=0.03)


@pytest.mark.parametrize("value", [0.0, np.nan, 8e6])
def test_an_actuator_that_rests_has_no_balance(value):
    still = np.full((2, 800), value)
    values, obstacles = measured(batch({P1: still, P2: still, X: still * 0, XV: still * 0}), "flow_balance")
    assert np.isnan([values["internal_coefficient"], values["leakage_error"]]).all()
    assert all(obstacles)


PRESSURE_LEAKS = np.array([0.0, 0.0, 0.0, 3e-10, 1e-9, 3e-9])


@pytest.fixture(scope="module")
def pressure_runs():
    """Healthy at three EBM, and three that leak; 10 s, without noise and position."""
    return without_position(simulated("record.duration=10 s", leaks=PRESSURE_LEAKS, moduli=MODULI))


@pytest.mark.parametrize(("chambers", "tolerance", "error"), [("both", 0.05, 1e-10), (1, 0.15, 3e-10)])
def test_leakage_comes_out_at_any_bulk_modulus(pressure_runs, chambers, tolerance, error):
    alone = pressure_runs if chambers == "both" else batch({c: pressure_runs[c] for c in (P1, U)})
    values, _ = measured(alone, "pressure_balance", chambers=chambers)
    np.testing.assert_allclose(values["internal_coefficient"], PRESSURE_LEAKS, rtol=tolerance, atol=error)
    assert (values["leakage_error"] < 0.2 / 60e3).all()
    assert_rows_stand_alone(alone, "pressure_balance", chambers=chambers)


@pytest.mark.parametrize("drive_period", [2.0, None])
def test_one_pressure_alone_is_enough_where_the_drive_is_a_square_wave(pressure_runs, drive_period):
    alone = batch({P1: pressure_runs[P1]}, drive_period=drive_period)
    options = {"chambers": 1, "spool": "square"}
    for records in (alone, alone.window(500)):
        values, _ = measured(records, "pressure_balance", **options)
        np.testing.assert_allclose(values["internal_coefficient"], PRESSURE_LEAKS, rtol=0.15, atol=3e-10)
    assert_rows_stand_alone(alone, "pressure_balance", **options)


def worst(records, leaks, **options):
    values, _ = measured(records, "pressure_balance", **options)
    return np.abs(values["internal_coefficient"] - leaks).max()


def test_jumps_of_a_load_in_closed_loop_are_weighed_down():
    leaks = np.array([0.0, 3e-10])
    settings = (
        *settings_of(LOOP), "record.duration=20 s", "control.amplitude=20 mm", "input.shape=steps",
        "input.period=1 s", "load.random_force=1 kN", "load.random_period=0.5 s",
    )  # fmt: skip
    shown = without_position(simulated(*settings, leaks=leaks, moduli=[551e6] * 2))
    robust, plain = (worst(shown, leaks, robust=way) for way in (True, False))
    assert robust < 1e-10
    assert plain > 3.0 * robust


def test_ringing_is_waited_for(pressure_runs):
    """Pressures ring after a step and the position does not; this must not count as leakage."""
    hurried = worst(pressure_runs, PRESSURE_LEAKS, settling=0.0, half_window=8)
    assert worst(pressure_runs, PRESSURE_LEAKS) < 0.2 * hurried


def without_position(records):
    return batch({channel: records[channel] for channel in (P1, P2, U)})
