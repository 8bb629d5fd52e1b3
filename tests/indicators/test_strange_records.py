"""Whatever a record holds, physical indicators give numbers, NaN or a reason, and leave the record alone."""

import numpy as np
import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel
from indicators.signals import P1, P2, U, batch, measured, noisy, simulated, square_wave

X, XV = Channel.PISTON_POSITION, Channel.SPOOL_POSITION

INDICATORS = make_indicators(
    {
        **{
            name: {} for name in ("a4", "cross_correlation", "flow_balance", "post_step_ac", "pressure_decay")
        },
        **{name: {} for name in ("pressure_statistics", "ring_down")},
        "one_pressure": {"kind": "flow_balance", "chambers": 1, "spool": "command"},
        "sum_of_pressures": {"kind": "flow_balance", "supply": "sum", "least_opening": 0.0},
        "rest_test": {"kind": "pressure_decay", "rest": "whole"},
        "standstill": {"kind": "pressure_decay", "rest": "position"},
        "jumps": {"kind": "ring_down", "steps": "signal", "trend_degree": 0, "delay": 0},
        "half_periods": {"kind": "ring_down", "steps": "period", "window": "0.06 s"},
    }
)

STRANGE = (
    lambda draw, time: 0.0 * time,
    lambda draw, time: np.nan * time,
    lambda draw, time: np.inf + time,
    lambda draw, time: 1e300 * draw.normal(size=time.size),
    lambda draw, time: 1e-320 * draw.normal(size=time.size),
    lambda draw, time: np.cumsum(draw.normal(size=time.size)),
    lambda draw, time: np.where(draw.random(time.size) < 0.01, np.nan, 1.0),
    lambda draw, time: square_wave(time.size, 30),
    lambda draw, time: 1.0 * time,
    lambda draw, time: np.round(draw.normal(size=time.size)),
    lambda draw, time: 1.0 * (time == time.size // 2),
    lambda draw, time: np.maximum(draw.normal(size=time.size), 0.0),
    lambda draw, time: 8e6 + 1e5 * draw.normal(size=time.size),
    lambda draw, time: square_wave(time.size, 30) * np.exp(-(time % 30) / 5.0),
)


@pytest.mark.parametrize("seed", range(200))
def test_any_record_is_measured(seed):
    draw = np.random.default_rng(seed)
    time = np.arange(draw.choice([1, 2, 17, 60, 100, 333, 1000]))
    rows = range(draw.integers(1, 4))
    channels = {
        channel: np.stack([STRANGE[draw.integers(len(STRANGE))](draw, time) for _ in rows])
        for channel in (P1, P2, U, X, XV)
    }
    records = batch(channels, drive_period=draw.choice([0.1, 2.0, 1e-4]))
    kept = {channel: samples.copy() for channel, samples in records.channels.items()}
    measures = measure(records, INDICATORS)
    assert all(len(value) == records.n_record for value in measures.values.values())
    assert not any(np.isinf(value).any() for value in measures.values.values())
    for channel, samples in kept.items():
        np.testing.assert_array_equal(records[channel], samples)


def test_a_batch_without_records_has_no_numbers():
    records = batch({channel: np.ones((1, 100)) for channel in (P1, P2, U, X, XV)}).rows([])
    measures = measure(records, INDICATORS)
    assert {len(value) for value in measures.values.values()} == {0}
    assert set(measures.obstacles.values()) == {()}


BLIND = {"spool": "command", "supply": "sum"}


@pytest.fixture(scope="module")
def healthy():
    """One healthy record of 8 s with sensor noise."""
    return noisy(simulated("record.duration=8 s", leaks=[0.0], moduli=[551e6]), 0, 1, seed=5)


@pytest.mark.parametrize("kind", ["weak_rls", "flow_balance", "adaptive_observer", "ekf_joint"])
@pytest.mark.parametrize(
    "option",
    [
        {"piston_area": 633},
        {"chamber_volume": "280 m^3"},
        {"bulk_modulus": "551 GPa"},
        {"supply_pressure": "17.2 GPa"},
    ],
)
def test_sizes_that_no_actuator_has_are_refused(kind, option):
    with pytest.raises(ConfigError, match="must be at most"):
        make_indicators({kind: option})


@pytest.mark.parametrize("option", ["supply_deviation", "flow_gain_deviation"])
def test_an_estimate_that_no_actuator_has_is_no_number(healthy, option):
    turned = healthy.rows([0])
    turned[U][:] *= -1.0
    values, (reason,) = measured(turned, "weak_rls", **BLIND, **{option: 1000.0})
    assert "not positive" in reason
    assert all(np.isnan(array).all() for array in values.values())


def test_every_estimate_of_the_valve_has_its_deviation(healthy):
    values, _ = measured(healthy, "weak_rls", **BLIND)
    truth = {"flow_gain": 1.0, "supply_pressure": 17.2e6, "offset": 0.0, "lap": 0.0, "clearance": 0.0}
    for name, true in truth.items():
        assert values[f"{name}_error"] > 0.0
        assert abs(values[name] - true) < 4.0 * values[f"{name}_error"], name


@pytest.mark.parametrize(("chambers", "misfit"), [("both", 1.05), (1, 2.0)])
def test_a_wrong_area_shows(healthy, chambers, misfit):
    right, _ = measured(healthy, "weak_rls", **BLIND, chambers=chambers)
    wrong, _ = measured(healthy, "weak_rls", **BLIND, chambers=chambers, piston_area="696 mm^2")
    assert right["misfit"] < 1.0
    assert right["departure"] < 1.5
    assert wrong["departure"] > 2.5
    assert wrong["misfit"] > misfit * right["misfit"]


def test_a_filter_of_the_wrong_plant_is_less_sure(healthy):
    right, _ = measured(healthy, "ekf_innovation", supply="nominal")
    wrong, _ = measured(healthy, "ekf_innovation", supply="nominal", piston_area="696 mm^2")
    assert wrong["nis"] > 1.5 > right["nis"]
    assert wrong["leakage_error"] > 1.2 * right["leakage_error"]
