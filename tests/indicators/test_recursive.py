"""What every recursive indicator keeps, read from the list of them."""

import numpy as np
import pytest

from hydrofdi.indicators import indicator_kind, indicator_names, make_indicators, measure
from hydrofdi.indicators.contract import RecursiveIndicator
from hydrofdi.indicators.faults import doubts_of
from indicators.signals import P1, P2, XV, U, X, batch, measured, noisy, simulated
from indicators.test_catalogue import all_channels

NAMES = [name for name in indicator_names() if issubclass(indicator_kind(name), RecursiveIndicator)]


def indicator_of(name, **options):
    (made,) = make_indicators({name: options}).values()
    return made


@pytest.mark.parametrize("name", NAMES)
class TestEachRecursiveIndicator:
    def test_keeps_the_trace_of_its_score_where_it_is_asked_to_and_refuses_shorter_records(self, name):
        records = all_channels(2)
        kept = indicator_of(name, trace_duration="4 s", interval="0.5 s")
        score = kept.estimates[0].name
        assert kept.estimates[0].is_score
        trace = measure(records, {name: kept}).values[f"{name}.{score}_trace"]
        assert trace.shape == (2, 8)
        np.testing.assert_array_equal(trace, kept.trace(records).values[score][:, :8])
        assert all(measure(records.window(0, 1800), {name: kept}).obstacles[name])
        assert all(measure(records, {name: indicator_of(name, transient="4 s")}).obstacles[name])

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


@pytest.mark.parametrize(("of", "output"), [("dwt", "d2"), ("flow_balance", ""), ("ring_down", "frequency")])
def test_each_number_is_that_of_its_window_measured_by_itself(of, output):
    records = all_channels(2)
    indicator = indicator_of("sliding", of=of, output=output, window="1.2 s", interval="0.3 s")
    name, n_window, every = indicator.options.followed.name, 600, 150
    numbers = indicator.trace(records).values[name]
    for place in range(numbers.shape[1]):
        stop = (place + 1) * every
        if stop < n_window:
            assert np.isnan(numbers[:, place]).all()
            continue
        window = measure(records.window(stop - n_window, stop), make_indicators({of: {}}))
        np.testing.assert_array_equal(numbers[:, place], window.values[f"{of}.{name}"])
    assert len(doubts_of(indicator, measure(records, {"it": indicator}).values, "it.")) == 2


def test_a_record_has_the_mean_over_its_windows_but_those_with_a_missing_sample():
    records = all_channels(2)
    indicator = indicator_of("sliding", output="d2", window="1 s", interval="0.5 s", transient="1.5 s")
    found = measure(records, {"it": indicator}).values
    numbers = indicator.trace(records).since(1.5).values["d2"]
    np.testing.assert_allclose(found["it.d2"], numbers.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(found["it.d2_spread"], numbers.std(axis=1), rtol=1e-12)
    records[P1][0, 900] = np.nan
    every = indicator_of("sliding", output="d2", window="1 s", interval="0.1 s")
    numbers = every.trace(records).values["d2"][0]
    ends = 50 * (np.arange(numbers.size) + 1)
    np.testing.assert_array_equal(np.isnan(numbers), (ends < 500) | ((ends > 900) & (ends <= 1400)))


def test_a_batch_without_records_has_no_numbers():
    records = batch({channel: np.ones((1, 100)) for channel in (P1, P2, U, X, XV)}).rows([])
    measures = measure(records, make_indicators(["dwt", "flow_balance", "ring_down", "pressure_decay"]))
    assert {len(value) for value in measures.values.values()} == {0}
    assert set(measures.obstacles.values()) == {()}


BLIND = {"spool": "command", "supply": "sum"}


@pytest.fixture(scope="module")
def healthy():
    """One healthy record of 8 s with sensor noise."""
    return noisy(simulated("record.duration=8 s", leaks=[0.0], moduli=[551e6]), [0], seed=5)


def test_every_estimate_of_the_valve_has_its_deviation(healthy):
    values, _ = measured(healthy, "weak_rls", **BLIND)
    truth = {"flow_gain": 1.0, "supply_pressure": 17.2e6, "offset": 0.0, "lap": 0.0, "clearance": 0.0}
    for name, true in truth.items():
        assert values[f"{name}_error"] > 0.0
        assert abs(values[name] - true) < 4.0 * values[f"{name}_error"], name


@pytest.mark.parametrize(
    ("name", "options", "factors"),
    [
        ("weak_rls", BLIND, {"departure": 1.5, "misfit": 1.05}),
        ("weak_rls", BLIND | {"chambers": 1}, {"departure": 1.5, "misfit": 2.0}),
        ("ekf_innovation", {"supply": "nominal"}, {"nis": 1.5, "leakage_error": 1.2}),
    ],
)
def test_a_wrong_area_shows(healthy, name, options, factors):
    right, _ = measured(healthy, name, **options)
    wrong, _ = measured(healthy, name, **options, piston_area="696 mm^2")
    for output, factor in factors.items():
        assert wrong[output] > factor * right[output], output
    assert all(right[output] < 1.5 for output in factors if output != "leakage_error")
