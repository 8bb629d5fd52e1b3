"""A recursive indicator follows a stream whatever its pieces, and begins anew where it has to."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.detectors.trained.configuration import Feature, Number, feature_of
from hydrofdi.detectors.trained.following import Estimator, Follower
from hydrofdi.detectors.trained.measuring import channel_facts, learned_range, records_of
from hydrofdi.indicators import indicator_kind, indicator_names
from hydrofdi.indicators.recursive import RecursiveIndicator, Trace
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk
from tests.detectors.trained.made import FREQUENCY, detector, signals, window

NAMES = [name for name in indicator_names() if issubclass(indicator_kind(name), RecursiveIndicator)]
OPTIONS = {"interval": 0.05, "transient": 0.2}
SLIDING = {"of": "dwt", "output": "d2", "window": 0.1}
N_SAMPLE = 1000
CUTS = st.lists(st.integers(1, N_SAMPLE - 1), max_size=5).map(lambda cuts: sorted({0, *cuts, N_SAMPLE}))


def follower_of(name="weak_rls", **options):
    more = {"options": OPTIONS | options, "direction": "both", "window": {"by": "estimate"}}
    return Follower(detector(name, limits=(-1e300, 1e300), **more))


def piece(first=0, stop=N_SAMPLE, begins_anew=None, lost=(), start=0.0):
    """Samples of a stream; those at the places `lost` have no P1."""
    rows = {channel: samples.copy() for channel, samples in signals(3).items()}
    rows[Channel.CHAMBER_1_PRESSURE][list(lost)] = np.nan
    time = start + np.arange(N_SAMPLE) / FREQUENCY
    part = {channel: samples[first:stop] for channel, samples in rows.items()}
    return Chunk(time[first:stop], part, begins_anew=first == 0 if begins_anew is None else begins_anew)


def followed(follower, *pieces):
    state, instants, verdicts = follower.start(), [], []
    for each in pieces:
        state, times, found = follower.step(state, each)
        instants += times.tolist()
        verdicts += found
    return instants, verdicts


class Forgetful(indicator_kind("sliding")):
    """A sliding number that is lost for good from an instant on, as that of a filter which diverged."""

    lost_from = 0.5

    def step(self, state, chunk):
        after, trace = super().step(state, chunk)
        values = {name: np.where(trace.time >= self.lost_from, np.nan, v) for name, v in trace.values.items()}
        return after, Trace(trace.time, values)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=8, deadline=None)
@given(cuts=CUTS, lost=st.sets(st.integers(0, N_SAMPLE - 1), max_size=3))
def test_verdicts_do_not_depend_on_the_pieces(name, cuts, lost):
    follower = follower_of(name)
    pieces = [piece(first, stop, lost=lost) for first, stop in pairwise(cuts)]
    assert followed(follower, *pieces) == followed(follower, piece(lost=lost))


@pytest.mark.parametrize("name", NAMES)
def test_estimates_are_those_of_the_record_after_the_transient(name):
    feature = feature_of(detector(name, options=OPTIONS, direction="both", window={"by": "estimate"}).config)
    channels = tuple(sorted(feature.indicator.channels))
    estimator = Estimator(feature, channels, FREQUENCY)
    _, found = estimator.step(estimator.start(), piece())
    trace = feature.indicator.trace(records_of([window(seed=3)], channels, FREQUENCY)).since(0.2 - 1e-9)
    np.testing.assert_array_equal([each.score for each in found], trace.values[feature.described.name][0])
    assert all(np.isfinite(each.score) == (each.fault is None) for each in found)
    np.testing.assert_allclose([each.time for each in found], trace.time, rtol=0, atol=1e-12)
    assert found[0].time >= 0.2 - 1e-9


def test_it_begins_anew_behind_a_gap():
    follower = follower_of()
    once = followed(follower, piece())
    again = followed(follower, piece(0, 700), piece(begins_anew=True, start=50.0))
    assert again[1][-len(once[1]) :] == once[1]
    np.testing.assert_allclose(again[0][-len(once[0]) :], np.array(once[0]) + 50.0, atol=1e-9)


def test_missing_samples_are_said_once_and_the_estimates_begin_anew_behind_them():
    instants, verdicts = followed(follower_of(), piece(lost=range(400, 420)))
    (place,) = (place for place, verdict in enumerate(verdicts) if verdict.fault is not None)
    assert verdicts[place].fault.kind == "missing"
    assert "chamber_1_pressure" in verdicts[place].fault.message
    assert instants[place] == 0.4
    assert instants[place + 1] == pytest.approx(0.42 + 0.2, abs=0.05)
    alone = followed(follower_of(), piece(420, begins_anew=True))[1]
    assert verdicts[place + 1 :] == alone


def test_an_indicator_that_lost_its_score_for_good_begins_anew_and_says_so():
    options = SLIDING | {"interval": 0.01, "transient": 0.1, "window": 0.1}
    made = Forgetful(Forgetful.Options.model_validate(options))
    feature = Feature({made.name: made}, (Number(made.name, made.estimates[0]),))
    estimator = Estimator(feature, tuple(feature.indicator.channels), FREQUENCY)

    def estimates(*cuts):
        state, found = estimator.start(), []
        for first, stop in pairwise([0, *cuts, N_SAMPLE]):
            state, more = estimator.step(state, piece(first, stop))
            found += [(each.time, each.fault, None if each.fault else each.score) for each in more]
        return found

    found = estimates()
    said = [(time, fault.message) for time, fault, _ in found if fault is not None]
    assert said[0] == (pytest.approx(0.509), "sliding has had no d2 for 0.01 s")
    assert said[9] == (
        pytest.approx(0.599),
        "sliding has had no d2 for 0.1 s; it restarts and gives no score for 0.1 s",
    )
    assert said[10:] == []
    assert next(time for time, _, _ in found if time > 0.6) == pytest.approx(0.709)
    assert estimates(123, 509, 510, 599, 600, 601) == found


def test_an_indicator_without_a_score_yet_is_waited_for():
    options = SLIDING | {"interval": 0.01, "transient": 0.0, "window": 0.7}
    _, verdicts = followed(follower_of("sliding", **options), piece())
    faults = [verdict.fault for verdict in verdicts if verdict.fault is not None]
    assert len(faults) == 69
    assert not any("restarts" in fault.message for fault in faults)
    assert verdicts[-1].alarm is False


def test_its_state_is_arrays_and_stays_as_it_was():
    follower = follower_of("ekf_joint")
    state, _, _ = follower.step(follower.start(), piece(0, 500))
    before = {name: np.array(array) for name, array in state.items()}
    first = follower.step(state, piece(500, begins_anew=False))
    assert all(array.dtype != object for array in before.values())
    for name, array in before.items():
        np.testing.assert_array_equal(state[name], array)
    assert follower.step(before, piece(500, begins_anew=False))[2] == first[2]


def healthy_ranges(channels):
    """What ten seconds of such a stream teach, looked at second by second."""
    rows = signals(3, 10 * N_SAMPLE)
    return {each: learned_range(each, channel_facts(rows[each].reshape(10, -1))) for each in channels}


def long_piece(change):
    """Six seconds; `change` gets the samples of the last three."""
    rows = {channel: samples.copy() for channel, samples in signals(3, 6 * N_SAMPLE).items()}
    time = np.arange(6 * N_SAMPLE) / FREQUENCY
    change(time[3000:], {channel: samples[3000:] for channel, samples in rows.items()})
    return Chunk(time, rows, begins_anew=True)


def stuck(_, rows):
    rows[Channel.CHAMBER_1_PRESSURE][:] = rows[Channel.CHAMBER_1_PRESSURE][0]


def clipped(_, rows):
    np.minimum(rows[Channel.CHAMBER_1_PRESSURE], 9.5e6, out=rows[Channel.CHAMBER_1_PRESSURE])


def novel(_, rows):
    rows[Channel.CHAMBER_1_PRESSURE][:] += 20e6


def slower(time, _):
    time[:] = time[0] + 1.1 * (time - time[0])


@pytest.mark.parametrize(
    ("change", "kind"), [(stuck, "stuck"), (clipped, "clipped"), (novel, "novel"), (slower, "other_rate")]
)
def test_estimates_of_unsound_samples_are_not_judged(change, kind):
    file = follower_of("sliding", **SLIDING).file
    follower = Follower(file.model_copy(update={"ranges": healthy_ranges(file.channels)}))
    whole = long_piece(change)
    instants, verdicts = followed(follower, whole)
    before = [verdict.fault for time, verdict in zip(instants, verdicts, strict=True) if time < 3.0]
    after = [verdict for time, verdict in zip(instants, verdicts, strict=True) if time > 4.1]
    assert len(before) > 50
    assert not any(before)
    assert {verdict.fault.kind for verdict in after} == {kind}
    assert all(verdict.alarm is None for verdict in verdicts if verdict.fault)
    parts = [whole.part(first, stop) for first, stop in pairwise([0, 1, 999, 3001, 3500, 3501, 6000])]
    assert followed(follower, *parts) == (instants, verdicts)
