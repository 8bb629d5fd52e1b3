"""What every indicator that follows a stream keeps, read from the list of them."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.indicators import indicator_kind, indicator_names, make_indicators, measure
from hydrofdi.indicators.recursive import RecursiveIndicator, instants
from indicators.test_catalogue import all_channels

NAMES = [name for name in indicator_names() if issubclass(indicator_kind(name), RecursiveIndicator)]
N_TIME = 1500

cuts = st.lists(st.integers(0, N_TIME), max_size=6).map(lambda places: [0, *sorted(places), N_TIME])


def indicator_of(name, **options):
    (made,) = make_indicators({name: options}).values()
    return made


@pytest.mark.parametrize("name", NAMES)
class TestEachRecursiveIndicator:
    @settings(max_examples=12, deadline=None)
    @given(places=cuts)
    def test_gives_a_stream_the_estimates_of_the_record(self, name, places):
        records = all_channels(2).window(0, N_TIME)
        indicator = indicator_of(name)
        whole = indicator.trace(records)
        state, traces = indicator.start(records.window(0, 0)), []
        for first, stop in itertools.pairwise(places):
            state, trace = indicator.step(state, records.window(first, stop))
            traces.append(trace)
        np.testing.assert_array_equal(np.concatenate([each.time for each in traces]), whole.time)
        for key, values in whole.values.items():
            chunked = np.concatenate([each.values[key] for each in traces], axis=1)
            np.testing.assert_array_equal(chunked, values, err_msg=key)

    def test_takes_single_samples(self, name):
        records = all_channels(2).window(0, 400)
        indicator = indicator_of(name)
        state, traces = indicator.start(records), []
        for place in range(records.n_time):
            state, trace = indicator.step(state, records.window(place, place + 1))
            traces.append(trace)
        for key, values in indicator.trace(records).values.items():
            np.testing.assert_array_equal(
                np.concatenate([each.values[key] for each in traces], axis=1), values, err_msg=key
            )

    def test_keeps_all_it_knows_in_arrays_and_leaves_a_state_as_it_was(self, name):
        records = all_channels(2)
        indicator = indicator_of(name)
        state, _ = indicator.step(indicator.start(records), records.window(0, 700))
        before = {key: array.copy() for key, array in state.items()}
        chunk = records.window(700, 1400)
        first, once = indicator.step(state, chunk)
        second, again = indicator.step(state, chunk)
        assert all(isinstance(array, np.ndarray) and array.dtype != object for array in first.values())
        for key, array in state.items():
            np.testing.assert_array_equal(array, before[key])
            np.testing.assert_array_equal(first[key], second[key])
        for key, values in once.values.items():
            np.testing.assert_array_equal(values, again.values[key])

    def test_keeps_the_trace_of_its_score_where_it_is_asked_to(self, name):
        records = all_channels(2)
        kept = indicator_of(name, trace_duration="4 s", interval="0.5 s")
        score = kept.estimates[0].name
        assert kept.estimates[0].is_score
        found = measure(records, {name: kept})
        trace = found.values[f"{name}.{score}_trace"]
        assert trace.shape == (2, 8)
        np.testing.assert_array_equal(trace, kept.trace(records).values[score][:, :8])
        short = measure(records.window(0, 1800), {name: kept})
        assert short.obstacles[name] == ("3.6 s are shorter than the trace of 4 s",) * 2

    def test_needs_records_longer_than_the_transient(self, name):
        found = measure(all_channels(1), {name: indicator_of(name, transient="4 s")})
        assert found.obstacles[name] == ("4 s are too few for a transient of 4 s and an interval of 0.1 s",)

    def test_marks_a_gap_from_its_instant_on(self, name):
        records = all_channels(2)
        indicator = indicator_of(name)
        before = indicator.trace(records)
        for channel in indicator.channels:
            records.channels[channel][1, 1000] = np.nan
        after = indicator.trace(records)
        score = indicator.estimates[0].name
        np.testing.assert_array_equal(after.values[score][0], before.values[score][0])
        earlier = after.time < 1000 / records.sampling_frequency - 0.2
        np.testing.assert_array_equal(after.values[score][1, earlier], before.values[score][1, earlier])


@given(n_before=st.integers(0, 50), sizes=st.lists(st.integers(0, 30), max_size=5), every=st.integers(1, 12))
def test_estimates_are_due_at_the_same_samples_whatever_the_chunks(n_before, sizes, every):
    """Counted from the start of the stream, every so many samples."""
    due, place = [], n_before
    for size in sizes:
        due += [place + each for each in instants(place, size, every).tolist()]
        place += size
    assert due == [each for each in range(n_before, place) if (each + 1) % every == 0]


def sliding(**options):
    (made,) = make_indicators({"sliding": options}).values()
    return made


@pytest.mark.parametrize(("of", "output"), [("dwt", "d2"), ("flow_balance", ""), ("ring_down", "frequency")])
def test_each_number_is_that_of_its_window_measured_by_itself(of, output):
    records = all_channels(2)
    indicator = sliding(of=of, output=output, window="1.2 s", interval="0.3 s")
    name, n_window, every = indicator.options.followed.name, 600, 150
    numbers = indicator.trace(records).values[name]
    for place in range(numbers.shape[1]):
        stop = (place + 1) * every
        if stop < n_window:
            assert np.isnan(numbers[:, place]).all()
            continue
        window = measure(records.window(stop - n_window, stop), make_indicators({of: {}}))
        np.testing.assert_array_equal(numbers[:, place], window.values[f"{of}.{name}"])


def test_a_record_has_the_mean_over_its_windows():
    records = all_channels(2)
    indicator = sliding(of="dwt", output="d2", window="1 s", interval="0.5 s", transient="1.5 s")
    found = measure(records, {"it": indicator}).values
    numbers = indicator.trace(records).since(1.5).values["d2"]
    np.testing.assert_allclose(found["it.d2"], numbers.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(found["it.d2_spread"], numbers.std(axis=1), rtol=1e-12)


def test_windows_with_a_missing_sample_have_no_number_and_later_ones_have():
    records = all_channels(1)
    samples = records["chamber_1_pressure"].copy()
    samples[0, 900] = np.nan
    records.channels["chamber_1_pressure"] = samples
    numbers = sliding(output="d2", window="1 s", interval="0.1 s").trace(records).values["d2"][0]
    ends = 50 * (np.arange(numbers.size) + 1)
    np.testing.assert_array_equal(np.isnan(numbers), (ends < 500) | ((ends > 900) & (ends <= 1400)))
