import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import EvenStream, make_windower, windows_of
from tests.records.streams.plain import accepted, chunks, cycle_windows, run, time_windows

P1, U = Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE
FREQUENCY = 100.0

steps = st.one_of(
    st.sampled_from([0.01] * 6 + [0.0, -0.01, -0.05, 0.02, 0.0149, 1.0, 61.0, np.nan, np.inf, -np.inf]),
    st.floats(0.008, 0.012),
)
samples = st.sampled_from([-1.0, -0.3, -0.15, 0.0, 0.15, 0.3, 1.0, np.nan])
sizes = st.lists(st.integers(1, 40), min_size=1, max_size=5)
edges = st.sampled_from(["rising", "falling", "both"])
windowings = st.one_of(
    st.fixed_dictionaries(
        {"by": st.just("time"), "n_sample": st.integers(1, 9), "n_every": st.integers(1, 12)}
    ),
    st.fixed_dictionaries({"by": st.just("cycle"), "n_sample": st.integers(1, 9), "edge": edges}),
)


@st.composite
def streams(draw):
    """A stream with defects: time and channels."""
    drawn = draw(st.lists(st.tuples(steps, samples), max_size=120))
    clock, time = 0.0, []
    for step, _ in drawn:
        time.append(clock + step)
        clock += step if np.isfinite(step) else 0.01
    values = np.array([value for _, value in drawn])
    return np.array(time, dtype=float), {P1: np.arange(len(drawn)) + 1e5 * values, U: values}


def _windower(windowing):
    return make_windower(**windowing, channels=(P1, U), sampling_frequency=FREQUENCY, drive=(-1.0, 1.0))


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


def _news(findings):
    return sorted((each.kind, str(each.time), each.text) for each in findings if each.is_news)


@settings(max_examples=300, deadline=None)
@given(streams(), windowings, sizes)
def test_windows_and_findings_do_not_depend_on_the_chunks(stream, windowing, sizes):
    time, channels = stream
    whole = run(EvenStream(FREQUENCY, (P1, U)), _windower(windowing), chunks(time, channels, [len(time) + 1]))
    parts = run(EvenStream(FREQUENCY, (P1, U)), _windower(windowing), chunks(time, channels, sizes))
    record = windows_of(time, channels, _windower(windowing))
    assert len(whole[1]) == len(parts[1]) == len(record)
    for one, other, third in zip(whole[1], parts[1], record, strict=True):
        _same(one, other)
        _same(one, third)
    assert _totals(whole[2]) == _totals(parts[2])
    assert _news(whole[2]) == _news(parts[2])
    for one, other in zip(whole[3], parts[3], strict=True):
        assert {name: array.tobytes() for name, array in one.items()} == {
            name: array.tobytes() for name, array in other.items()
        }


@settings(max_examples=300, deadline=None)
@given(streams(), windowings, sizes)
def test_windows_are_those_of_a_loop_over_samples(stream, windowing, sizes):
    time, channels = stream
    places, totals = accepted(time, FREQUENCY)
    if windowing["by"] == "time":
        expected = time_windows(places, windowing["n_sample"], windowing["n_every"])
    else:
        expected = cycle_windows(places, channels[U], (-1.0, 1.0), windowing["n_sample"], windowing["edge"])
    _, windows, findings, _ = run(
        EvenStream(FREQUENCY, (P1, U)), _windower(windowing), chunks(time, channels, sizes)
    )
    assert [window.time.tolist() for window in windows] == [time[each].tolist() for each in expected]
    for window, each in zip(windows, expected, strict=True):
        np.testing.assert_array_equal(window.channels[P1], channels[P1][each])
        assert (window.fault is not None and window.fault.kind == "short_cycle") == (
            len(each) < windowing["n_sample"]
        )
    assert [window.number for window in windows] == list(range(len(windows)))
    assert _totals(findings) == totals
