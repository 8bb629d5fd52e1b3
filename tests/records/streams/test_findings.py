import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hydrofdi.records.batch import Channel
from hydrofdi.records.streams import Chunk, EvenStream
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


def _stream(time, frequency=10.0, state=None):
    stream, time = EvenStream(frequency, (P1,)), np.asarray(time, dtype=float)
    return stream.step(state or stream.start(), Chunk(time, {P1: np.arange(float(time.size))}))


MALFORMED = "has no time stamp within 1e11 s of zero and was dropped"


def _said(time, frequency=10.0):
    return [(each.kind, each.count, each.text) for each in _stream(time, frequency)[2]]


@pytest.mark.parametrize(
    ("time", "said"),
    [
        ([0.0, 0.1, 0.4, 0.5], ("gap", 1, "no samples for 0.3 s after 0.1 s")),
        ([0.0, 0.1, 0.1, 0.2], ("duplicate", 1, "a second sample at 0.1 s was dropped")),
        (
            [0.3, 0.4, 0.2, 0.3, 0.5],
            ("time_ran_back", 2, "a sample at 0.2 s came after one at 0.4 s and was dropped"),
        ),
        ([0.0, np.nan, 0.1], ("malformed", 1, f"a sample after 0 s {MALFORMED}")),
        ([0.0, 1e300, 0.1, -1.1e11], ("malformed", 2, f"a sample after 0 s {MALFORMED}")),
        ([np.nan, np.inf, 0.0], ("malformed", 2, f"a sample {MALFORMED}")),
        ([1e11, 1e11 + 0.1], ("malformed", 1, f"a sample after 100000000000 s {MALFORMED}")),
        (
            [1.7e9, 1.7e9 + 0.100001, 1.7e9 + 0.6],
            ("gap", 1, "no samples for 0.499999 s after 1700000000.100001 s"),
        ),
    ],
)
def test_findings_say_what_happened_and_when(time, said):
    assert _said(time) == [said]


@pytest.mark.parametrize("time", [[], [5.0], [0.0, 0.1, 0.2], [0.0, 0.149, 0.2, 0.251, 0.4], [-7.0, -6.9]])
def test_nothing_is_said_of_an_even_stream_whose_stamps_jitter(time):
    _, pieces, findings = _stream(time)
    assert findings == []
    assert [piece.time.tolist() for piece in pieces] == ([time] if time else [])


def test_pieces_end_at_gaps_and_have_every_channel():
    stream = EvenStream(10.0, (P1, Channel.PISTON_POSITION))
    time = np.array([0.0, 0.1, 0.1, 1.0, 1.1])
    channels = {P1: np.arange(5.0), Channel.INPUT_VOLTAGE: np.zeros(5)}
    state, pieces, _ = stream.step(stream.start(), Chunk(time, channels))
    assert [(piece.time.tolist(), piece.begins_anew) for piece in pieces] == [
        ([0.0, 0.1], True),
        ([1.0, 1.1], True),
    ]
    assert [set(piece.channels) for piece in pieces] == [set(stream.channels)] * 2
    assert pieces[1].channels[P1].tolist() == [3.0, 4.0]
    assert np.isnan(pieces[1].channels[Channel.PISTON_POSITION]).all()
    _, (goes_on,), _ = stream.step(state, Chunk(np.array([1.2]), {P1: np.zeros(1)}))
    assert not goes_on.begins_anew


def test_another_rate_is_said_as_one_and_not_as_gaps_for_ever():
    findings = _stream(np.arange(1000) / 5.0)[2]
    assert [(each.kind, each.count) for each in findings if not each.is_silent] == [
        ("gap", 9),
        ("rate_changed", 990),
    ]
    assert findings[1].text == "samples come every 0.2 s instead of every 0.1 s"


def test_what_goes_on_is_no_news_until_a_minute_without_it():
    minute = np.arange(0.0, 59.95, 0.1)
    often = np.sort(np.concatenate([minute, minute[::10]]))
    seldom = np.concatenate([often, [65.0, 65.0, 130.0, 130.0]])
    twice = [each for each in _stream(seldom)[2] if each.kind == "duplicate"]
    assert [(each.time, each.count, not each.is_silent) for each in twice] == [
        (0.0, 61, True),
        (130.0, 1, True),
    ]


def test_a_clock_that_was_set_back_is_believed_after_a_minute():
    before, after = 7200.0 + np.arange(100) / 10.0, 3600.0 + np.arange(1000) / 10.0
    _, pieces, findings = _stream(np.concatenate([before, after]))
    assert pieces[1].begins_anew
    assert pieces[1].time.tolist() == after[599:].tolist()
    assert findings[-1].text == "the clock was set back from 7209.9 s; the stream restarts at 3659.9 s"


def test_each_clock_that_was_set_back_is_news():
    hour = 3600.0 + np.arange(100) / 10.0
    findings = _stream(np.concatenate([hour, *[hour[0] - n - np.arange(600) / 1e4 for n in (1, 2, 3)]]))[2]
    assert [each.count for each in findings if "set back" in each.text and not each.is_silent] == [1, 1, 1]


def test_one_stamp_far_in_the_future_does_not_blind_for_ever():
    time = np.arange(2000) / 10.0
    time[100] = 1e9
    _, pieces, _ = _stream(time)
    assert [piece.time.size for piece in pieces] == [100, 1, 2000 - 101 - 599]


def test_samples_that_come_again_after_a_restart_are_dropped_in_silence():
    stream, time = EvenStream(10.0, (P1,)), np.arange(1000) / 10.0
    state, _, _ = _stream(time[:900])
    _, pieces, findings = _stream(time, state=stream.resumed(state))
    assert findings == []
    assert [(piece.time.tolist(), piece.begins_anew) for piece in pieces] == [(time[900:].tolist(), False)]


def test_after_the_first_new_sample_of_a_restart_findings_come_again():
    stream = EvenStream(10.0, (P1,))
    state, _, _ = _stream([0.0, 0.1])
    findings = _stream([0.0, 0.1, 0.2, 0.1, 5.0], state=stream.resumed(state))[2]
    assert sorted(each.kind for each in findings) == ["gap", "time_ran_back"]


def test_a_clock_may_be_set_back_after_the_stream_came_again():
    stream, time = EvenStream(10.0, (P1,)), 7200.0 + np.arange(100) / 10.0
    state, _, _ = _stream(time[:50])
    state, _, _ = _stream(time, state=stream.resumed(state))
    assert [piece.time[0] for piece in _stream(np.arange(1000) / 10.0, state=state)[1]] == [59.9]


@pytest.mark.parametrize("may_repeat", [True, False])
def test_a_clock_that_began_anew_while_the_monitor_was_down_is_believed_after_a_minute(may_repeat):
    stream, time = EvenStream(10.0, (P1,)), np.arange(1000) / 10.0
    state, _, _ = _stream(7200.0 + time)
    _, pieces, findings = _stream(time, state=stream.resumed(state, may_repeat=may_repeat))
    assert [piece.time[0] for piece in pieces] == [time[599]]
    assert [each.text for each in findings] == [
        "the clock was set back from 7299.9 s; the stream restarts at 59.9 s"
    ]


def test_a_logger_whose_clock_begins_at_zero_again_is_told_from_a_stream_that_comes_again():
    stream, time = EvenStream(10.0, (P1,)), np.arange(3000) / 10.0
    channels = {P1: np.sin(time)}
    state, _, _ = stream.step(stream.start(), Chunk(time, channels))
    for n in (900, 300, 300, 300, 900):  # killed during each repetition
        again = Chunk(time[:n], {P1: np.sin(time[:n])})
        state, pieces, findings = stream.step(stream.resumed(state), again)
        assert (pieces, findings) == ([], [])
    _, pieces, _ = stream.step(stream.resumed(state), Chunk(time, {P1: np.cos(time)}))
    assert [piece.time[0] for piece in pieces] == [time[599]]


def test_a_step_leaves_its_state_as_it_was():
    state, _, _ = _stream([0.0, 0.1, 0.1])
    before = {name: array.copy() for name, array in state.items()}
    _stream([0.1, 0.0, np.nan, 9.0], state=state)
    for name, array in before.items():
        np.testing.assert_array_equal(state[name], array)


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
    return [(each.kind, each.time, each.text) for each in findings if not each.is_silent]


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
