"""Mistakes of a first hour: a column for a row, another channel, novel windows overlooked."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import DataError

RATE = {"sampling_frequency": "1 kHz"}


def noisy(n_record, scale=1.0):
    return 80.0 + scale * np.random.default_rng(1).standard_normal((n_record, 1000))


def test_a_column_is_not_taken_for_records_of_one_sample():
    with pytest.raises(DataError, match=r"shape \(1000, 1\) is 1,000 records of 1 sample; transpose it or"):
        hydrofdi.measure(noisy(1).T, **RATE)


def test_records_without_any_channel_of_the_indicators_are_refused():
    frame = {"piston position [mm]": noisy(1)[0], "u [V]": noisy(1)[0]}
    with pytest.raises(DataError, match=r"has no chamber_1_pressure; found 'piston position', 'u'"):
        hydrofdi.measure(frame, "dwt", **RATE)


def test_windows_that_are_beyond_the_limit_but_novel_are_not_overlooked():
    detector = hydrofdi.train(
        noisy(200), output="d2", direction="rising", false_alarm_rate="2 %", unit="bar", **RATE
    )
    table = detector.judge(noisy(5, scale=4.0), unit="bar", **RATE)
    assert table["beyond_limit"].tolist() == [True] * 5
    assert "5 windows beyond the limit were not judged: novel" in repr(table)


def test_a_channel_that_no_indicator_uses_does_not_mark_a_record():
    records = {"P1 [bar]": noisy(1)[0], "Ps [bar]": np.zeros(1000)}
    assert "stuck" in hydrofdi.inspect(records, **RATE).remarks
    assert hydrofdi.measure(records, "dwt", **RATE)["status"].tolist() == ["ok"]
    records = {"P1 [bar]": np.full(1000, 172.0)}
    assert hydrofdi.measure(records, "dwt", **RATE)["status"].tolist() == ["stuck"]
