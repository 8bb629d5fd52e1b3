import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk, EvenStream
from tests.records.streams.plain import (
    accepted,
    chunks,
    cycle_windows,
    make_windower,
    run,
    time_windows,
    windows_of,
)  # fmt: skip

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION
V, U = Channel.PISTON_VELOCITY, Channel.INPUT_VOLTAGE


def _stream(time, frequency=10.0, state=None):
    stream, time = EvenStream(frequency, (P1,)), np.asarray(time, dtype=float)
    return stream.step(state or stream.start(), Chunk(time, {P1: np.arange(float(time.size))}))


EVEN = 0.1 * np.arange(1000)


@pytest.mark.parametrize(("time", "found", "n_accepted"), [
    ([0.0, 1e300, 0.1, -1.1e11], {"malformed": 2}, 2), ([1e11, 1e11 + 0.1], {"malformed": 1}, 1),
    (2.0 * EVEN, {"gap": 9, "rate_changed": 990}, 1000), ([], {}, 0),
    # a clock that was set back is believed after a minute; so is one after a single stamp far ahead
    (np.concatenate([7200.0 + EVEN[:100], 3600.0 + EVEN]), {"time_ran_back": 600}, 501),
    (np.concatenate([EVEN[:100], [1e9], EVEN[100:]]), {"gap": 1, "time_ran_back": 600}, 402),
])  # fmt: skip
def test_irregularities_are_counted_and_irregular_samples_dropped(time, found, n_accepted):
    _, pieces, events = _stream(time)
    assert (_totals(events), sum(piece.time.size for piece in pieces)) == (found, n_accepted)
    n_set_back = sum("set back" in each.text and not each.is_silent for each in events)
    assert n_set_back == found.get("time_ran_back", 0) // 600


def test_what_goes_on_is_no_news_until_a_minute_without_it():
    minute = np.arange(0.0, 59.95, 0.1)
    often = np.sort(np.concatenate([minute, minute[::10]]))
    seldom = np.concatenate([often, [65.0, 65.0, 130.0, 130.0]])
    twice = [each for each in _stream(seldom)[2] if each.kind == "duplicate"]
    assert [(each.time, each.count) for each in twice] == [(0.0, 61), (130.0, 1)]
    assert not any(each.is_silent for each in twice)


def test_samples_that_come_again_after_a_restart_are_dropped_in_silence_until_the_first_new_one():
    stream, time = EvenStream(10.0, (P1,)), np.arange(1000) / 10.0
    state, _, _ = _stream(time[:900])
    state, pieces, findings = _stream(time, state=stream.resumed(state))
    assert findings == []
    assert [(piece.time.tolist(), piece.begins_anew) for piece in pieces] == [(time[900:].tolist(), False)]
    assert sorted(each.kind for each in _stream([99.8, 200.0], state=state)[2]) == ["gap", "time_ran_back"]
    assert [piece.time[0] for piece in _stream(time[:700] - 9.0, state=state)[1]] == [50.9]


@pytest.mark.parametrize("may_repeat", [True, False])
def test_a_clock_that_began_anew_while_the_monitor_was_down_is_believed_after_a_minute(may_repeat):
    stream, time = EvenStream(10.0, (P1,)), np.arange(1000) / 10.0
    state, _, _ = _stream(7200.0 + time)
    _, pieces, findings = _stream(time, state=stream.resumed(state, may_repeat=may_repeat))
    assert [piece.time[0] for piece in pieces] == [time[599]]
    assert [each.kind for each in findings] == ["time_ran_back"]


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
    st.builds(dict, by=st.just("time"), n_sample=st.integers(1, 9), n_every=st.integers(1, 12)),
    st.builds(dict, by=st.just("cycle"), n_sample=st.integers(1, 9), edge=edges),
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


def _windower(windowing, frequency):
    return make_windower(**windowing, channels=(P1, U), sampling_frequency=frequency, drive=(-1.0, 1.0))


def _same(one, other):
    assert (one.number, one.fault, one.time.tobytes()) == (other.number, other.fault, other.time.tobytes())
    assert {each: row.tobytes() for each, row in one.channels.items()} == {
        each: row.tobytes() for each, row in other.channels.items()
    }


def _totals(findings):
    totals = {}
    for finding in findings:
        totals[finding.kind] = totals.get(finding.kind, 0) + finding.count
    return totals


@settings(max_examples=400, deadline=None)
@given(streams(), windowings, sizes)
def test_windows_and_findings_are_those_of_a_loop_over_samples_whatever_the_chunks(stream, windowing, sizes):
    frequency, time, channels = stream
    even, windower = EvenStream(frequency, (P1, U)), _windower(windowing, frequency)
    whole, parts = (run(even, windower, chunks(time, channels, each)) for each in ([len(time) + 1], sizes))
    record = windows_of(time, channels, windower)
    for one, other, third in zip(whole[1], parts[1], record, strict=True):
        _same(one, other)
        _same(one, third)
    said = [
        [(each.kind, each.time, each.text) for each in found if not each.is_silent]
        for found in (whole[2], parts[2])
    ]
    assert said[0] == said[1]
    for state, other in zip(whole[3], parts[3], strict=True):
        assert {name: array.tobytes() for name, array in state.items()} == {
            name: array.tobytes() for name, array in other.items()
        }
        assert all(array.base is None for array in other.values())  # never more than a window is kept
        assert sum(array.nbytes for array in other.values()) < 24 * windowing["n_sample"] + 200
    assert not any(np.shares_memory(window.channels[P1], channels[P1]) for window in record)
    places, totals = accepted(time, frequency)
    assert _totals(whole[2]) == _totals(parts[2]) == totals
    if windowing["by"] == "time":
        expected = time_windows(places, windowing["n_sample"], windowing["n_every"])
    else:
        expected = cycle_windows(places, channels[U], (-1.0, 1.0), windowing["n_sample"], windowing["edge"])
    assert [window.time.tolist() for window in record] == [time[each].tolist() for each in expected]
    for number, (window, each) in enumerate(zip(record, expected, strict=True)):
        assert window.number == number
        np.testing.assert_array_equal(window.channels[P1], channels[P1][each])
        is_short = window.fault is not None and window.fault.kind == "short_cycle"
        assert is_short == (len(each) < windowing["n_sample"])


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
    begin, again = ({each: row[some] for each, row in channels.items()} for some in (slice(stop), rest))
    _, first, before, states = run(stream, windower, chunks(time[:stop], begin, sizes))
    stored = {name: array.copy() for name, array in states[0].items()}, states[1]
    parts = chunks(time[rest], again, sizes)
    _, second, after, _ = run(stream, windower, parts, (stream.resumed(stored[0]), stored[1]))
    assume(frequency == 100.0 or not any("set back" in finding.text for finding in after))
    assert len(first) + len(second) == len(expected)
    for one, other in zip(expected, first + second, strict=True):
        _same(one, other)
    assert all(count <= _totals(said)[kind] for kind, count in _totals(before + after).items())


FREQUENCY, N = 100.0, 300


def _healthy():
    time = np.arange(N) / FREQUENCY
    wave = np.sin(2.0 * np.pi * time)
    return time, {P1: 5e6 + 4e6 * wave, P2: 5e6 - 4e6 * wave, X: 0.1 * wave, V: -0.1 * wave, U: 2.0 * wave}


def _fault(time, samples, channels=(P1, P2, X, V, U), frequency=FREQUENCY):
    windower = make_windower("time", N, channels=channels, sampling_frequency=frequency)
    (window,) = windows_of(time, samples, windower)
    return window.fault


def _all_rest(samples):
    samples[X][:] = samples[U][:] = 1.0
    samples[P1], samples[P2] = (5e6 + 0.01 * (samples[channel] - 5e6) for channel in (P1, P2))


@pytest.mark.parametrize(("change", "kind", "part"), [
    (lambda samples: None, None, ""), (lambda samples: samples.pop(X), "missing_channel", X),
    (lambda samples: samples[P2].put([3, 299], np.inf), "missing", "2 of 300"),
    (lambda samples: samples[V].fill(0.1), "stuck", V), (lambda samples: samples[P1].fill(5e6), "stuck", P1),
    (lambda samples: samples[X].fill(np.nan), "missing_channel", X),
    (lambda samples: samples[X][100:250].fill(samples[X][100]), "stuck", "1.5 s"),
    (lambda samples: samples[U].fill(1.0), None, ""),
    (_all_rest, None, ""),
], ids=["sound", "no channel", "inf", "v", "P1", "nan", "frozen x", "command rests", "all rest"])  # fmt: skip
def test_what_is_missing_or_stuck_is_said_and_rest_is_no_fault(change, kind, part):
    time, samples = _healthy()
    change(samples)
    fault = _fault(time, samples)
    assert (fault and fault.kind) == kind
    assert fault is None or part in fault.message
    assert kind is None or part not in (P1, P2) or _fault(time, samples, channels=(X,)) is None


JITTER = np.where(np.arange(N) % 20 == 10, 1.0 / FREQUENCY, 0.0)
STAMPS = np.arange(N) / FREQUENCY


@pytest.mark.parametrize(("time", "kind", "frequency"), [
    (STAMPS + 0.2 * JITTER, None, 100.0), (STAMPS + 0.4 * JITTER, "uneven", 100.0),
    (np.round(STAMPS / 6.0, 3), None, 600.0), (STAMPS / 0.98, "other_rate", 100.0),
    (STAMPS / 0.992, None, 100.0), (STAMPS / 1.008, None, 100.0), (STAMPS / 1.02, "other_rate", 100.0),
], ids=["0.2 steps", "0.4 steps", "rounded", "98 %", "99.2 %", "100.8 %", "102 %"])  # fmt: skip
def test_stamps_may_jitter_by_a_quarter_of_a_step_and_the_mean_rate_differ_by_a_hundredth(
    time, kind, frequency
):
    fault = _fault(time, _healthy()[1], frequency=frequency)
    assert (fault and fault.kind) == kind


def test_the_unit_of_a_time_in_another_one_is_asked_for():
    time, samples = _healthy()
    assert "in exceldays?" in _fault(time / 86_400.0, samples).message
    for factor, unit in ((1e3, "ms"), (1e6, "µs")):
        assert f"in {unit}?" in _stream(time * factor, FREQUENCY)[2][-1].text
