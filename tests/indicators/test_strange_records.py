"""Whatever a record holds, physical indicators give numbers, NaN or a reason, and leave the record alone."""

import numpy as np
import pytest

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel
from indicators.signals import P1, P2, U, batch, square_wave

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
