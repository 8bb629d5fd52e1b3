"""Flow balance: K_i and β of simulated runs come out, together."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.indicators.catalogue.flow_balance import FlowBalanceOptions
from hydrofdi.records import Channel
from hydrofdi.simulation import simulate_batch
from indicators.signals import P1, P2, U, assert_rows_stand_alone, batch, measured

X, XV = Channel.PISTON_POSITION, Channel.SPOOL_POSITION
LEAKS = np.array([0.0, 0.0, 0.0, 1e-9, 5e-9, 1.3e-8])
MODULI = np.array([551e6, 689e6, 827e6, 551e6, 689e6, 551e6])


@pytest.fixture(scope="module")
def runs():
    """Healthy at three EBM, and three that leak; 6 s, without noise."""
    parameters = [
        load_experiment(None, [f"fluid.bulk_modulus={modulus} Pa", "record.duration=6 s"]).nominal_parameters
        for modulus in MODULI
    ]
    signals = simulate_batch(parameters, list(LEAKS))
    return batch(
        {
            P1: signals.chamber_1_pressure,
            P2: signals.chamber_2_pressure,
            X: signals.piston_position,
            XV: signals.spool_position,
            U: signals.input_voltage,
        }
    )


def noisy(records, row, n_record, seed):
    """Copies of a run with sensor noise: 5 kPa, 10 µm, 0.2 µm of the spool."""
    draw = np.random.default_rng(seed)
    sizes = {P1: 5e3, P2: 5e3, X: 10e-6, XV: 0.2e-6, U: 0.0}
    return batch(
        {
            channel: records[channel][row] + size * draw.normal(size=(n_record, records.n_time))
            for channel, size in sizes.items()
        }
    )


@pytest.mark.parametrize("options", [{}, {"chambers": "1"}, {"spool": "command"}, {"half_window": 6}])
def test_leakage_and_bulk_modulus_of_simulated_runs_come_out(runs, options):
    values, _ = measured(runs, "flow_balance", **options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=1e-3, atol=1e-13)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=1e-3)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)


def test_switching_windows_cost_a_little_when_they_are_kept(runs):
    values, _ = measured(runs, "flow_balance", switching="kept")
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.01, atol=1e-11)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=0.01)


def test_a_flow_gain_and_an_offset_that_are_not_nominal_are_found(runs):
    other = replace(runs, channels={**runs.channels, XV: runs[XV] + 0.5e-6})
    options = {"flow_gain": 0.0292 / 1.05, "estimate": ["flow_gain", "offset"]}
    values, _ = measured(other, "flow_balance", **options)
    np.testing.assert_allclose(values["flow_gain"], 1.05, rtol=2e-3)
    np.testing.assert_allclose(values["offset"], 0.5e-6 * 1.05, rtol=0.02)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.01, atol=1e-11)
    alone, _ = measured(runs, "flow_balance")
    assert (values["condition"] > 5.0 * alone["condition"]).all()


def test_a_wrong_area_or_volume_scales_what_it_should(runs):
    values, _ = measured(
        runs, "flow_balance", piston_area=2 * 633e-6, flow_gain=2 * 0.0292, chamber_volume=560e-6
    )
    np.testing.assert_allclose(values["internal_coefficient"], 2 * LEAKS, rtol=1e-3, atol=1e-13)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=1e-3)


@pytest.mark.parametrize("row", [0, 3])
@pytest.mark.parametrize("name", ["internal_coefficient", "bulk_modulus"])
def test_the_stated_deviations_are_those_of_repeats(runs, row, name):
    values, _ = measured(noisy(runs, row, 200, seed=row), "flow_balance")
    truth = {"internal_coefficient": LEAKS, "bulk_modulus": MODULI}[name][row]
    stated = values[f"{name}_error"].mean()
    assert 0.4 * stated < values[name].std() < 1.5 * stated
    assert abs(values[name].mean() - truth) < 2.0 * stated


def test_the_supply_may_be_measured_nominal_or_the_sum_of_the_pressures(runs):
    measured_supply = replace(
        runs, channels={**runs.channels, Channel.SUPPLY_PRESSURE: np.full(runs[P1].shape, 17.2e6)}
    )
    no_scale = replace(measured_supply, relative=frozenset({Channel.SUPPLY_PRESSURE}))
    wrong, _ = measured(no_scale, "flow_balance", supply_pressure="16 MPa")
    right, _ = measured(measured_supply, "flow_balance", supply_pressure="16 MPa")
    total, _ = measured(runs, "flow_balance", supply_pressure="16 MPa", supply="sum")
    error = [np.abs(v["internal_coefficient"] - LEAKS).max() for v in (wrong, right, total)]
    assert error[1] < 1e-11 < error[2] < 1e-10 < error[0]


def test_chambers_may_differ(runs):
    """Chamber 2 given in other units of area and volume is chamber 2 in other units."""
    one = FlowBalanceOptions(piston_area_2=1e-4, chamber_volume_2=2e-4)
    assert one.areas == (633e-6, 1e-4)
    assert one.volumes == (280e-6, 2e-4)
    same, _ = measured(runs, "flow_balance", piston_area_2=633e-6, chamber_volume_2=280e-6)
    np.testing.assert_array_equal(same["bulk_modulus"], measured(runs, "flow_balance")[0]["bulk_modulus"])


def test_a_record_stands_alone(runs):
    for options in ({}, {"spool": "command", "supply": "sum"}):
        assert_rows_stand_alone(runs, "flow_balance", **options)


def test_a_later_start_changes_little(runs):
    whole, part = (measured(r, "flow_balance")[0] for r in (runs, runs.window(333)))
    np.testing.assert_allclose(part["bulk_modulus"], whole["bulk_modulus"], rtol=1e-3)


def test_counts_are_refused_and_short_records_too(runs):
    counts = replace(runs, relative=frozenset({P2}))
    assert "is in counts" in measured(counts, "flow_balance")[1][0]
    assert "4 windows are too few" in measured(runs.window(0, 40), "flow_balance")[1][0]
    assert "has no spool_position" in measured(batch({P1: [1.0], P2: [1.0], X: [1.0]}), "flow_balance")[1][0]


@pytest.mark.parametrize("value", [0.0, np.nan, 8e6])
def test_an_actuator_that_rests_has_no_balance(value):
    still = np.full((2, 800), value)
    values, obstacles = measured(batch({P1: still, P2: still, X: still * 0, XV: still * 0}), "flow_balance")
    assert np.isnan(values["internal_coefficient"]).all()
    assert np.isnan(values["leakage_error"]).all()
    assert obstacles[0] == "the balance does not determine a leakage"


def test_white_noise_has_a_leakage_that_its_error_covers():
    draw = np.random.default_rng(5)
    channels = {P1: 8e6 + 1e5 * draw.normal(size=(50, 4000)), P2: 8e6 + 1e5 * draw.normal(size=(50, 4000))}
    channels |= {X: 1e-5 * draw.normal(size=(50, 4000)), XV: np.zeros((50, 4000))}
    values, _ = measured(batch(channels), "flow_balance")
    assert (np.abs(values["leakage"]) < 3.0 * values["leakage_error"]).mean() > 0.9
