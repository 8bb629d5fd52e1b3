"""Adaptive observer: K_i and β of simulated runs come out, sample by sample."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.indicators import make_indicators
from hydrofdi.records import Channel
from indicators.signals import LEAKS, MODULI, P1, P2, measured, simulated


@pytest.fixture(scope="module")
def runs():
    return simulated("record.duration=16 s")


def measured_by(records, **options):
    """Output → numbers."""
    values, obstacles = measured(records, "adaptive_observer", **options)
    assert obstacles == (None,) * records.n_record
    return values


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"supply": "nominal"}])
def test_leakage_and_bulk_modulus_of_a_known_actuator_come_out(runs, options):
    values = measured_by(runs, transient="12 s", **options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.02, atol=3e-11)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=0.08)


def test_leakage_alone_may_be_adapted(runs):
    values = measured_by(runs, estimate=["leakage"], transient="12 s")
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.04, atol=1e-10)
    assert "bulk_modulus" not in values


def test_it_settles_with_its_time_constant(runs):
    """At the mean of the pressure differences, which the law is in proportion to."""
    row, time_constant = 4, 1.5 * 8e6 / np.abs(runs[P1] - runs[P2])[4].mean()
    (indicator,) = make_indicators({"adaptive_observer": {"estimate": ["leakage"]}}).values()
    trace = indicator.trace(runs)
    flow = trace.values["leakage"][row] / trace.values["leakage"][row, -1]
    settled = trace.time[np.flatnonzero(flow > 1.0 - np.exp(-1.0))[0]]
    assert settled == pytest.approx(time_constant, rel=0.25)


def test_a_wrong_supply_counts_as_leakage_and_a_measured_one_does_not(runs):
    supply = np.full_like(runs[P1], 17.2e6)
    with_supply = replace(runs, channels={**runs.channels, Channel.SUPPLY_PRESSURE: supply})
    wrong = measured_by(with_supply, supply="nominal", supply_pressure="16 MPa", transient="12 s")
    right = measured_by(with_supply, supply_pressure="16 MPa", transient="12 s")
    errors = (np.abs(each["internal_coefficient"] - LEAKS).max() for each in (wrong, right))
    assert next(errors) > 4e-10 > 2e-10 > next(errors)


def test_nothing_is_learned_while_the_valve_is_closed(runs):
    values, obstacles = measured(runs, "adaptive_observer", least_opening="1 mm")
    assert all("did not adapt" in obstacle for obstacle in obstacles)
    assert all(np.isnan(numbers).all() for numbers in values.values())


def test_an_estimate_that_is_not_physical_is_a_status_with_a_sentence(runs):
    values, obstacles = measured(runs, "adaptive_observer", leakage_time="1e-6 s")
    assert "it diverged: K_i or β is not physical" in obstacles[0]
    assert all(np.isnan(array).all() for array in values.values())
