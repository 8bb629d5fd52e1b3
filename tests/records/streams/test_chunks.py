import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hydrofdi.records.batch import Channel
from hydrofdi.records.streams import EvenStream
from tests.records.streams.plain import (
    accepted,
    chunks,
    cycle_windows,
    make_windower,
    run,
    time_windows,
    windows_of,
)

P1, U = Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE
steps = st.one_of(
    st.sampled_from([1.0] * 6 + [0.0, -1.0, -5.0, 2.0, 1.49, 1.51, 100.0, -100.0, np.nan, np.inf, -np.inf]),
    st.floats(0.8, 1.2),
)
"""Time from one sample to the next, in periods; a time stamp, where it is not finite."""
samples = st.lists(st.sampled_from([-1.0, -0.3, -0.15, 0.0, 0.15, 0.3, 1.0, np.nan]), min_size=1, max_size=5)
sizes = st.lists(st.integers(1, 40), min_size=1, max_size=5)
frequencies = st.sampled_from([0.1, 0.3, 100.0])
"""A clock that was set back is believed after 10, 18, 6000 samples."""
edges = st.sampled_from(["rising", "falling", "both"])
windowings = st.one_of(
    st.fixed_dictionaries(
        {"by": st.just("time"), "n_sample": st.integers(1, 9), "n_every": st.integers(1, 12)}
    ),
    st.fixed_dictionaries({"by": st.just("cycle"), "n_sample": st.integers(1, 9), "edge": edges}),
)


@st.composite
def streams(draw):
    """A stream with defects: frequency, time and channels."""
    frequency = draw(frequencies)
    drawn = draw(st.lists(st.tuples(steps, st.integers(1, 15)), max_size=20))
    clock, time = draw(st.sampled_from([0.0, -3.0, 1.7e9])), []
    for step, times in drawn:
        for _ in range(times):
            time.append(clock + step / frequency)
            clock = time[-1] if np.isfinite(step) else clock + 1.0 / frequency
    values = np.resize(draw(samples), len(time))
    return frequency, np.array(time, dtype=float), {P1: np.arange(len(time)) + 1e5 * values, U: values}


def _run(stream, windowing, sizes):
    frequency, time, channels = stream
    windower = _windower(windowing, frequency)
    return run(EvenStream(frequency, (P1, U)), windower, chunks(time, channels, sizes))


def _windower(windowing, frequency):
    return make_windower(**windowing, channels=(P1, U), sampling_frequency=frequency, drive=(-1.0, 1.0))


def _same(one, other):
    assert (one.number, one.fault, one.time.tobytes()) == (other.number, other.fault, other.time.tobytes())
    assert {each: row.tobytes() for each, row in one.channels.items()} == {
        each: row.tobytes() for each, row in other.channels.items()
    }


def _bytes(state):
    return {name: array.tobytes() for name, array in state.items()}


def _part(channels, part):
    return {channel: row[part] for channel, row in channels.items()}


def _totals(findings):
    totals = {}
    for finding in findings:
        totals[finding.kind] = totals.get(finding.kind, 0) + finding.count
    return totals


def _news(findings):
    return [(each.kind, each.time, each.text) for each in findings if each.is_news]


@settings(max_examples=300, deadline=None)
@given(streams(), windowings, sizes)
def test_windows_and_findings_do_not_depend_on_the_chunks(stream, windowing, sizes):
    frequency, time, channels = stream
    whole, parts = _run(stream, windowing, [len(time) + 1]), _run(stream, windowing, sizes)
    record = windows_of(time, channels, _windower(windowing, frequency))
    assert len(whole[1]) == len(parts[1]) == len(record)
    for one, other, third in zip(whole[1], parts[1], record, strict=True):
        _same(one, other)
        _same(one, third)
    assert _totals(whole[2]) == _totals(parts[2])
    assert _news(whole[2]) == _news(parts[2])
    assert [_bytes(state) for state in whole[3]] == [_bytes(state) for state in parts[3]]


@settings(max_examples=300, deadline=None)
@given(streams(), windowings, sizes)
def test_windows_are_those_of_a_loop_over_samples(stream, windowing, sizes):
    frequency, time, channels = stream
    places, totals = accepted(time, frequency)
    if windowing["by"] == "time":
        expected = time_windows(places, windowing["n_sample"], windowing["n_every"])
    else:
        expected = cycle_windows(places, channels[U], (-1.0, 1.0), windowing["n_sample"], windowing["edge"])
    _, windows, findings, _ = _run(stream, windowing, sizes)
    assert [window.time.tolist() for window in windows] == [time[each].tolist() for each in expected]
    for window, each in zip(windows, expected, strict=True):
        np.testing.assert_array_equal(window.channels[P1], channels[P1][each])
        is_short = window.fault is not None and window.fault.kind == "short_cycle"
        assert is_short == (len(each) < windowing["n_sample"])
    assert [window.number for window in windows] == list(range(len(windows)))
    assert _totals(findings) == totals


@settings(max_examples=200, deadline=None)
@given(streams(), windowings, sizes, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_stream_that_comes_again_after_a_restart_gives_the_same_windows(
    stream, windowing, sizes, stop, again
):
    frequency, time, channels = stream
    if frequency < 100.0:  # a minute is as few as ten samples: all of the stream comes again
        again = 0.0
    stream = EvenStream(frequency, (P1, U))
    windower = _windower(windowing, frequency)
    _, expected, said, _ = run(stream, windower, chunks(time, channels, sizes))
    assume(not any("set back" in finding.text for finding in said))
    stop = int(stop * time.size)
    rest = slice(int(again * stop), None)
    _, first, before, states = run(stream, windower, chunks(time[:stop], _part(channels, slice(stop)), sizes))
    stored = {name: array.copy() for name, array in states[0].items()}, states[1]
    parts = chunks(time[rest], _part(channels, rest), sizes)
    _, second, after, _ = run(stream, windower, parts, (stream.resumed(stored[0]), stored[1]))
    assume(frequency == 100.0 or not any("set back" in finding.text for finding in after))
    assert len(first) + len(second) == len(expected)
    for one, other in zip(expected, first + second, strict=True):
        _same(one, other)
    assert all(count <= _totals(said)[kind] for kind, count in _totals(before + after).items())
