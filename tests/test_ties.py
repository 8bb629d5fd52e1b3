"""Limits that computed values equal exactly: the answer does not depend on the last bit."""

import numpy as np
import pytest
from indicators.signals import P1, P2, U, X, batch, measured

from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.catalogue.spectra import _lines
from hydrofdi.indicators.catalogue.transients import half_periods, jumps
from hydrofdi.records.recording import Record, Stroke, _resampled, drive_edges, find_stroke, short_stroke
from hydrofdi.records.streams import Chunk, EvenStream, Joining
from hydrofdi.settings.messages import shown_quantity

LEVELS = range(1, 60)
TIMES = np.arange(20)
STREAM = EvenStream(500.0, (P1,))


def converted(levels, lowest=-10.0, resolution=0.01):
    """Readings of a converter, for levels from the middle of its range."""
    return lowest + resolution * (np.asarray(levels) - round(lowest / resolution))


@pytest.mark.parametrize("answer", [
    # a change of half the largest
    lambda n: jumps(converted(n * np.repeat([[-1, 1, 0, 1]], 50, axis=1)), 5, 20).sample,
    # ten levels of a converter within the time of the largest speed at rest, and a command at its limit
    lambda n: decay(X, converted(n + 10 * (np.arange(500) // 250), 0.0, 1e-5), rest="position"),
    lambda n: decay(U, converted(np.full(500, 2), -n), rest="command"),
    # bounds of a band on lines of the spectrum
    lambda n: _lines((50.0, 50.0), 500.0 / (10 * n), 1000 * n)[1] / n,
    # a clock of milliseconds at 500 Hz: steps of half a period and of one and a half
    lambda n: len(STREAM.step(STREAM.start(), stamps(n, n + 2, n + 5))[1]),
    lambda n: joined(n).n_time,
    # 2 %, 20 % and 98 % of a stroke, and its length
    lambda n: find_stroke(n / 100 + RISE / 1e3).start,
    lambda n: find_stroke(n / 100 + n * RISE / 1e4).arrival,
    lambda n: drive_edges(
        n / 7 + n * np.array([0, 60, 100, 0, 60]) / 1e4, (n / 7, n / 7 + n * 100 / 1e4), "rising"
    )[0],
    lambda n: short_stroke(Record({}, 500.0, ("",)), Stroke((n + 10) / 100 - n / 100, 0, 1), 0.1),
    # the ends of half periods and of a record, on clocks that began long before
    lambda n: half_periods(1, 500, 1000.0, 0.2, 1.7e9 * (n % 2)).sample,
    lambda n: _resampled({P1: RISE}, 3600.0 * n + np.arange(RISE.size) / 1e3, 1e3)[P1].size,
    # of equal peaks of a correlation, the earliest
    lambda n: measured(batch({P1: pulses(n, 500), P2: pulses(n, 470, 530)}), "cross_correlation")[0]["lag"],
])  # fmt: skip
def test_a_value_at_a_limit_has_the_same_answer_wherever_it_is_rounded(answer):
    assert len({np.asarray(answer(n)).tobytes() for n in LEVELS}) == 1


RISE = np.concatenate([np.zeros(50), np.arange(101), np.full(50, 100)])


def stamps(*milliseconds):
    time = np.array(milliseconds) / 1e3
    return Chunk(time, {P1: np.zeros(time.size)})


def joined(millisecond):
    """Two channels, stamped half a period apart."""
    values = np.array([[0.0, np.nan], [np.nan, 0.0]])
    chunk = Chunk((millisecond + np.arange(2)) / 1e3, dict(zip((P1, P2), values, strict=True)))
    joining = Joining(500.0, (P1, P2))
    return joining.step(joining.start(), chunk, is_end=True)[1]


def pulses(scale, *places):
    return np.isin(np.arange(1000), places) * np.sqrt(scale)


def decay(channel, samples, **options):
    channels = {P1: 8e6 + 0 * samples, P2: 0 * samples, channel: samples}
    return measured(batch(channels), "pressure_decay", **options)[0]["duration"]


def test_times_that_fill_a_record_and_bands_of_two_lines_fit():
    records = batch({P1: np.zeros(150)})
    bands = {
        "reduced_order": {"transient": 0.1, "interval": 0.2},
        "stft": {"band": [1.2, 9.2], "segment": 0.25},
    }
    assert [each.obstacle(records) for each in make_indicators(bands).values()] == [None, None]
    assert shown_quantity(0.3 - 0.2, "s") == "0.1 s"
