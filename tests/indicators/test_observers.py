"""Adaptive observer, reduced order and Volterra series on simulated runs."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.indicators import load_indicators, make_indicators, measure
from hydrofdi.records import Channel
from indicators.signals import LEAKS, MODULI, P1, P2, U, X, batch, measured, simulated
from tests.conftest import REPOSITORY


@pytest.fixture(scope="module")
def runs():
    return simulated("record.duration=16 s")


def measured_by(records, name="adaptive_observer", **options):
    """Output → numbers."""
    values, obstacles = measured(records, name, **options)
    assert obstacles == (None,) * records.n_record
    return values


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"supply": "nominal"}])
def test_leakage_and_bulk_modulus_of_a_known_actuator_come_out(runs, options):
    values = measured_by(runs, transient="12 s", **options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.02, atol=3e-11)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=0.08)


def test_leakage_alone_may_be_adapted_and_settles_with_its_time_constant(runs):
    """At the mean of the pressure differences, which the law is in proportion to."""
    values = measured_by(runs, estimate=["leakage"], transient="12 s")
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.04, atol=1e-10)
    assert "bulk_modulus" not in values
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


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("adaptive_observer", {"least_opening": "1 mm"}), ("adaptive_observer", {"leakage_time": "1e-6 s"}),
        ("reduced_order", {"least_opening": "1 mm"}),
    ],
)  # fmt: skip
def test_a_closed_valve_or_a_divergence_gives_no_numbers(runs, name, options):
    values, obstacles = measured(runs, name, **options)
    assert all(obstacles)
    assert all(np.isnan(numbers).all() for numbers in values.values())


SEALED, SMALL, LARGE = 0.0, 4e-10, 4e-9


@pytest.fixture(scope="module")
def reduced_runs(runs):
    return runs.window(0, 3000)


@pytest.fixture(scope="module")
def uncertain():
    """Ten actuators unlike their data sheet, each sealed, with a small and with a large leak."""
    draw = np.random.default_rng(3)
    gains = 0.0292 * (1 + 0.025 * draw.uniform(-1.0, 1.0, 10))
    supplies = 17.2 * (1 + 0.045 * draw.uniform(-1.0, 1.0, 10))
    each = [
        [f"valve.flow_gain={gain} m^1.5/kg^0.5", f"supply.pressure={supply} MPa"]
        for gain, supply in zip(np.repeat(gains, 3), np.repeat(supplies, 3), strict=True)
    ]
    return simulated("record.duration=6 s", leaks=[SEALED, SMALL, LARGE] * 10, moduli=[551e6] * 30, each=each)


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"supply": "nominal"}])
def test_the_residual_of_a_known_actuator_is_its_leakage(reduced_runs, options):
    nominal = np.flatnonzero(MODULI == 551e6)
    values = measured_by(reduced_runs.rows(nominal.tolist()), "reduced_order", **options)
    np.testing.assert_allclose(values["residual"], np.sqrt(8e6) * LEAKS[nominal], rtol=0.03, atol=1e-7)
    np.testing.assert_allclose(values["exceedance"], values["residual"] - values["bound"], rtol=1e-9)


def test_an_adaptive_threshold_lowers_false_alarms_and_loses_small_leaks(uncertain):
    """Fixed: zero, as a nominal actuator has it. Adaptive: what the bounds allow."""
    values = measured_by(uncertain, "reduced_order", supply="nominal")
    fixed, adaptive = ((values[name] > 0.0).reshape(10, 3) for name in ("residual", "exceedance"))
    assert fixed[:, 0].mean() > 0.3
    assert adaptive[:, 0].mean() == 0.0
    assert fixed[:, 1].mean() > adaptive[:, 1].mean() + 0.2
    assert fixed[:, 2].all()
    assert adaptive[:, 2].all()


def test_the_bound_knows_how_the_supply_is_known(reduced_runs):
    supply = np.full_like(reduced_runs[P1], 17.2e6)
    with_supply = replace(reduced_runs, channels={**reduced_runs.channels, Channel.SUPPLY_PRESSURE: supply})
    bounds = [
        measured_by(with_supply, "reduced_order", supply=each)["bound"]
        for each in ("measured", "sum", "nominal")
    ]
    assert (bounds[0] < bounds[1]).all()
    assert (bounds[1] < bounds[2]).all()
    given = measured_by(with_supply, "reduced_order", supply="measured", supply_bound=0.05)["bound"]
    np.testing.assert_allclose(given, bounds[2], rtol=0.05)


def test_equal_pressures_tell_nothing(reduced_runs):
    equal = replace(reduced_runs, channels={**reduced_runs.channels, P2: reduced_runs[P1]})
    values, obstacles = measured(equal, "reduced_order")
    assert obstacles[0]
    assert np.isnan(values["residual"]).all()


def moved(n_record=3, n_time=4000):
    """Records in which the position follows the command, by a law that differs from record to record."""
    draw = np.random.default_rng(4)
    command = np.repeat(draw.uniform(-2.0, 2.0, (n_record, n_time // 100)), 100, axis=1)
    speed = np.linspace(0.04, 0.06, n_record)[:, None] * command
    pressure = 8.6e6 + 2e6 * command + draw.normal(0.0, 1e4, command.shape)
    return batch({U: command, X: np.cumsum(speed, axis=1) / 500.0, P1: pressure, P2: 17.2e6 - pressure})


@pytest.mark.parametrize("signal", ["position_rate", "load_pressure"])
def test_coefficients_count_in_the_scales_that_are_given(signal):
    one = measured(moved(), "volterra", signal=signal, ridge=0.0)[0]
    scales = {"input_scale": "4 V", "pressure_scale": "17.2 MPa", "rate_scale": "0.2 m/s"}
    other = measured(moved(), "volterra", signal=signal, ridge=0.0, **scales)[0]
    factors = [0.5, 1.0, 1.0, 2.0, 2.0, 2.0]
    np.testing.assert_allclose(other["coefficients"], factors * one["coefficients"], atol=1e-7)
    np.testing.assert_allclose(other["left"], 0.5 * one["left"], rtol=1e-5, atol=1e-10)


def test_the_preset_judges_the_distance_of_the_coefficients():
    preset = REPOSITORY / "configs/detectors/volterra.yaml"
    chosen = load_indicators(str(preset))
    assert load_experiment(preset, ["study.healthy={fit: 3, test: 2}"]).detection.scores["volterra_distance"]
    assert all(np.isfinite(array).all() for array in measure(moved(), chosen).values.values())
