"""Detectors of one number, of several, and of streams."""

import itertools

import numpy as np
import pytest
from indicators.signals import P1, batch
from indicators.test_catalogue import all_channels

from detectors.streams import autoregressive
from hydrofdi.detectors import (
    DistanceDetector,
    Feature,
    IndicatorDetector,
    RecursiveDetector,
    healthy_scale,
)
from hydrofdi.detectors.charts import chart_names, make_chart
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.indicators import indicator_kind, indicator_names, make_indicators
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.recursive import RecursiveIndicator, RecursiveOptions, Trace, instants
from hydrofdi.records import Channel
from hydrofdi.scoring import make_score

RECURSIVE = [name for name in indicator_names() if issubclass(indicator_kind(name), RecursiveIndicator)]


class Smoothed(RecursiveIndicator[RecursiveOptions]):
    """The pressure with a lag: the smallest indicator of a stream."""

    name = "smoothed"
    version = 1
    summary = "A lagged pressure."
    source = "none"
    Options = RecursiveOptions
    direction = Direction.RISING

    @property
    def channels(self):
        return frozenset({P1})

    @property
    def estimates(self):
        return (Output("level", "Pa", "lagged pressure", direction=self.direction),)

    def start(self, records):
        return {"level": np.zeros(records.n_record), "n": np.zeros(1, dtype=int)}

    def step(self, state, chunk):
        level, levels = state["level"], np.empty((chunk.n_record, chunk.n_time))
        for place in range(chunk.n_time):
            level = 0.95 * level + 0.05 * chunk[P1][:, place]
            levels[:, place] = level
        n_before = int(state["n"][0])
        due = instants(n_before, chunk.n_time, self.samples_per_estimate(chunk.sampling_frequency))
        return {"level": level, "n": state["n"] + chunk.n_time}, Trace(
            chunk.time[due], {"level": levels[:, due]}
        )

    def of_record(self, trace):
        return {"level": trace.values["level"].mean(axis=1)}


def pressures(seed, n_record=40, shift=0.0, n_time=2000):
    return batch({P1: 8e6 + 1e5 * (shift + autoregressive(seed, n_record, n_time, 0.9, 0.5))})


def in_chunks(detector, model, records, places):
    state, parts = detector.start(model, records.window(0, 0)), []
    for first, stop in itertools.pairwise([0, *places, records.n_time]):
        state, scores = detector.step(state, records.window(first, stop))
        parts.append(scores)
    return np.hstack(parts)


def kind_of(name):
    window = {"output": "d2", "window": "1 s"} if name == "sliding" else {}
    (made,) = make_indicators({name: {"transient": "1 s"} | window}).values()
    return made


@pytest.mark.parametrize(
    ("name", "chart"),
    [("smoothed", chart) for chart in (None, *chart_names())] + [(name, "cusum") for name in RECURSIVE],
)
def test_a_stream_has_the_scores_of_the_record_to_the_bit(name, chart):
    indicator = Smoothed() if name == "smoothed" else kind_of(name)
    records = pressures(1, 8) if name == "smoothed" else all_channels(6)
    options = {"window": 5} if chart in ("glr", "moving_window") else {}
    made = chart and make_chart(chart, options)
    direction = Feature(indicator, indicator.estimates[0].name).described.direction or Direction.BOTH
    detector = RecursiveDetector(indicator, made, direction=direction, limit=3.0)
    model = detector.fit(records)
    whole = in_chunks(detector, model, records, [])
    for places in ([1, 2, 3, 777], [500], [499, 501, 1200]):
        np.testing.assert_array_equal(in_chunks(detector, model, records, places), whole)
    np.testing.assert_array_equal(detector.score(model, records), np.fmax.reduce(whole, axis=1))


def test_scores_begin_after_the_transient_of_the_stream():
    records = pressures(2, 6)
    detector = RecursiveDetector(Smoothed(RecursiveOptions(transient=1.0, interval=0.5)))
    model = detector.fit(records)
    later = batch({P1: records[P1]}, start_time=100.0)
    for stream in (records, later):
        scores = in_chunks(detector, model, stream, [700])
        assert np.isnan(scores[:, :2]).all()
        assert np.isfinite(scores[:, 2:]).all()


def test_healthy_scores_of_a_stream_are_standardised():
    records = pressures(3, 60)
    detector = RecursiveDetector(Smoothed())
    scores = in_chunks(detector, detector.fit(records), records, [])
    low, centre, high = np.nanquantile(scores, [0.25, 0.5, 0.75])
    assert centre == pytest.approx(0.0, abs=1e-9)
    assert high - low == pytest.approx(1.349, rel=1e-3)


def test_a_stream_that_has_diverged_has_no_score():
    records = pressures(4, 6)
    detector = RecursiveDetector(Smoothed(), make_chart("cusum"))
    model = detector.fit(pressures(5))
    records[P1][2, :] = np.nan
    score = detector.score(model, records)
    assert np.isnan(score[2])
    assert np.isfinite(np.delete(score, 2)).all()


def test_a_falling_score_is_turned_before_the_chart():
    class Falling(Smoothed):
        direction = Direction.FALLING

    rising = make_chart("cusum", {"direction": "rising"})
    healthy = pressures(6)
    for kind, shift in ((Smoothed, 3.0), (Falling, -3.0)):
        detector = RecursiveDetector(kind(), rising)
        model = detector.fit(healthy)
        leaking, other = (detector.score(model, pressures(7, shift=s)) for s in (shift, -shift))
        assert np.median(leaking) > 40.0 > np.median(other)


def test_records_without_the_channel_are_named():
    with pytest.raises(ConfigError, match="smoothed needs chamber_1_pressure"):
        RecursiveDetector(Smoothed()).fit(batch({Channel.INPUT_VOLTAGE: np.zeros((5, 2000))}))


def indicator(name, **options):
    (made,) = make_indicators({name: options}).values()
    return made


def test_one_number_is_scored_in_healthy_spreads_towards_the_leak():
    mean = Feature(indicator("pressure_statistics"), "mean")
    for direction, sign in (("rising", 1.0), ("falling", -1.0)):
        detector = IndicatorDetector(mean, Direction(direction))
        model = detector.fit(pressures(8, 200))
        assert model.n == 200
        scores = detector.score(model, pressures(9, 50, shift=sign * 5.0))
        assert np.median(scores) == pytest.approx(5e5 / model.spread, rel=0.1)
    both = IndicatorDetector(mean, Direction.BOTH)
    model = both.fit(pressures(8, 200))
    for shift in (-5.0, 5.0):
        assert np.median(both.score(model, pressures(9, 50, shift=shift))) > 5.0


def test_an_output_without_a_direction_wants_one():
    with pytest.raises(ConfigError, match=r"direction in which pressure_statistics\.mean raises an alarm"):
        IndicatorDetector(Feature(indicator("pressure_statistics"), "mean"))
    with pytest.raises(ConfigError, match="has no output 'means'; did you mean 'mean'"):
        IndicatorDetector(Feature(indicator("pressure_statistics"), "means"))


def test_one_score_wants_one_number():
    traced = Feature(Smoothed(RecursiveOptions(trace_duration=1.0)), "level_trace")
    with pytest.raises(ConfigError, match="level_trace has 10 values, but a single number is needed"):
        IndicatorDetector(traced, Direction.RISING).fit(pressures(10))


def test_what_cannot_be_learned_is_refused_with_the_reason():
    mean = IndicatorDetector(Feature(indicator("pressure_statistics"), "mean"), Direction.RISING)
    with pytest.raises(
        NotStatedError, match=r"no healthy record has pressure_statistics\.mean: has no chamber_1"
    ):
        mean.fit(batch({Channel.INPUT_VOLTAGE: np.zeros((5, 2000))}))
    with pytest.raises(NotStatedError, match="5 healthy scores, not 4"):
        mean.fit(pressures(12, 4))
    with pytest.raises(NotStatedError, match="no feature varies"):
        healthy_scale(np.ones(10))


def test_several_numbers_find_what_none_of_them_shows():
    """Details of two levels rise and fall together in health; one of them alone with the fault."""
    pytest.importorskip("sklearn")
    features = [Feature(indicator("dwt"), name) for name in ("d1", "d2", "d3")]

    def records(seed, added):
        drawn = np.random.default_rng(seed)
        size = drawn.lognormal(0.0, 0.5, (60, 1))
        noise = drawn.standard_normal((60, 2000))
        return batch({P1: 8e6 + 1e5 * size * (noise + added * np.diff(noise, prepend=0.0, axis=1))})

    detector = DistanceDetector(features)
    healthy, faulty = records(13, 0.0), records(14, 0.3)
    model = detector.fit(healthy)
    same = detector.score(model, records(15, 0.0))
    assert np.median(detector.score(model, faulty)) > np.quantile(same, 0.95)
    for feature in features:
        alone = IndicatorDetector(feature, Direction.BOTH)
        scale = alone.fit(healthy)
        assert np.median(alone.score(scale, faulty)) < np.quantile(alone.score(scale, records(15, 0.0)), 0.95)
    with pytest.raises(ConfigError, match="lda requires faulty records"):
        DistanceDetector(features, make_score("lda"))


def test_a_scale_leaves_out_what_is_missing():
    scale = healthy_scale(np.array([[1.0, 2.0, np.nan], [3.0, 4.0, 5.0]]))
    assert (scale.centre, scale.n) == (3.0, 5)
    np.testing.assert_allclose(scale([3.0, np.nan]), [0.0, np.nan])
