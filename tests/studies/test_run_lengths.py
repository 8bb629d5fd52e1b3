"""Charts on traces whose run lengths and delays are known; what they may see, and what not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtri

from hydrofdi.config.study import OnlineConfig, WatchedChart
from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction
from hydrofdi.studies.detecting import Traces, judge_chart
from tests.studies.populations import FIT, LEVELS, STIFFER, TEST, study

SMALL, LARGE = LEVELS[0], LEVELS[-1]
INTERVAL, N_INSTANT, ONSET, EVERY = 0.5, 200, 50.0, 1000.0
LATENT = 3
"""Instants between the onset and the rise of a leak."""


def traces(sizes=None, unit=2e-6, seed=0, **changes):
    """Independent normal scores of centre `unit` and spread `unit`; a leak adds its severity times ten."""
    records = study(sizes or {FIT: 200, TEST: 100, SMALL: 40, LARGE: 40, STIFFER: 30})
    time = 2.0 + INTERVAL * np.arange(N_INSTANT)
    scores = np.random.default_rng(seed).normal(size=(records.of_record.size, N_INSTANT))
    rises = time >= ONSET + LATENT * INTERVAL
    scores += 10.0 * np.where(records.severity > 0.0, records.severity, 0.0)[:, None] * rises
    onset = np.where(records.severity > 0.0, ONSET, np.nan)
    flow = records.severity.copy()
    made = Traces(records, unit * (1.0 + scores), time, onset, flow, "m^3/s", Direction.RISING)
    return replace(made, **changes)


def judged(of, every=EVERY, chart="ewma", **options):
    options = {"weight": 1} | options if chart == "ewma" else options
    asked = WatchedChart(of="made.up", chart=chart, options=options)
    online = OnlineConfig(false_alarm_every=every, charts={"own": asked})
    return list(judge_chart(of, "own", asked, online, Rules()))


def test_a_plain_limit_is_the_quantile_of_the_wanted_run_length_and_finds_a_leak_as_its_score_rises():
    """Independent scores exceed it once in so many, in fit records and in those that no limit saw."""
    (found,) = judged(traces())
    assert found.centre == pytest.approx(2e-6, rel=0.03)
    assert found.spread == pytest.approx(2e-6, rel=0.03)
    assert found.limit.value == pytest.approx(ndtri(1.0 - INTERVAL / EVERY), abs=0.3)
    tested = found.false_alarms[TEST]
    assert tested.duration == pytest.approx(100 * N_INSTANT * INTERVAL)
    assert tested.low < EVERY < tested.high
    assert found.keeps(TEST)
    small, large = found.delays
    assert (small.population, large.population) == (SMALL, LARGE)
    assert large.n_found == large.n == 40
    assert large.median.value == large.late.value == pytest.approx(LATENT * INTERVAL)
    assert small.median.value > large.median.value
    assert large.flow == pytest.approx(1.0, rel=0.02)
    assert large.watched == pytest.approx(2.0 + INTERVAL * (N_INSTANT - 1) - ONSET)


def test_test_records_do_not_move_the_limit():
    """Only healthy fit records do."""
    whole = traces()
    of_record = whole.records.of_record
    is_fit = of_record == whole.records.populations.index(FIT)
    (before,) = judged(whole)
    (others,) = judged(replace(whole, values=np.where(is_fit[:, None], whole.values, 5.0 * whole.values)))
    (own,) = judged(replace(whole, values=np.where(is_fit[:, None], 5.0 * whole.values, whole.values)))
    assert (others.limit, others.centre, others.spread) == (before.limit, before.centre, before.spread)
    assert own.spread == pytest.approx(5.0 * before.spread)
    assert others.false_alarms[TEST].n_alarm > before.false_alarms[TEST].n_alarm


@pytest.mark.parametrize("poison", ["severity", "flow", "names"])
def test_charts_do_not_see_what_is_true_of_a_record(poison):
    whole = traces()
    records = whole.records
    named = tuple(replace(each, name=f"x{k}") for k, each in enumerate(records.populations))
    changed = {
        "severity": {"records": replace(records, severity=-records.severity[::-1])},
        "flow": {"flow": 7.0 * whole.flow[::-1] + 1.0},
        "names": {"records": replace(records, populations=named)},
    }[poison]
    (before,), (after,) = judged(whole), judged(replace(whole, **changed))
    assert after.limit == before.limit
    assert list(after.false_alarms.values()) == list(before.false_alarms.values())
    for delay, same in zip(before.delays, after.delays, strict=True):
        assert (delay.median, delay.late, delay.n_early) == (same.median, same.late, same.n_early)


def test_alarms_before_the_onset_are_false_ones_and_no_detections():
    whole = traces()
    (row, *_) = whole.records.rows(SMALL)
    values = whole.values.copy()
    values[row, :3] = 1.0
    values[row, whole.time >= ONSET] = 0.0
    (before,), (after,) = judged(whole), judged(replace(whole, values=values))
    assert after.delays[0].n_early == before.delays[0].n_early + 3
    assert after.delays[0].n_found <= before.delays[0].n_found
    assert after.delays[0].n == before.delays[0].n


def test_leaks_that_are_there_from_the_start_and_runs_that_failed_have_no_delay():
    whole = traces()
    large = whole.records.rows(LARGE)
    onset, flow = whole.onset.copy(), whole.flow.copy()
    onset[whole.records.rows(SMALL)] = np.nan
    flow[large[:10]] = np.nan
    (found,) = judged(replace(whole, onset=onset, flow=flow))
    (delay,) = found.delays
    assert (delay.population, delay.n) == (LARGE, 30)


def test_an_estimator_that_diverged_finds_nothing():
    whole = traces()
    values = whole.values.copy()
    large = whole.records.rows(LARGE)
    values[large[:5], N_INSTANT // 4 :] = np.nan
    (found,) = judged(replace(whole, values=values))
    assert found.delays[-1].n_found == 35
    assert found.delays[-1].not_measurable == 5


def test_too_little_time_is_no_verdict_without_many_alarms_and_no_limit():
    few = traces({FIT: 200, TEST: 20, LARGE: 5})
    short, long = judged(few, every=[EVERY, 1e5])
    assert short.keeps(TEST) is None
    assert short.false_alarms[TEST].duration < 3.0 * EVERY
    assert long.limit is None
    assert len(long.refusals) == 1
    assert long.keeps(TEST) is None
    values = few.values.copy()
    values[few.records.rows(TEST)] *= 3.0
    (found,) = judged(replace(few, values=values))
    assert found.keeps(TEST) is False


def test_too_few_records_of_a_shift_concern_this_shift_alone():
    (found,) = judged(traces({FIT: 200, TEST: 100, LARGE: 40, STIFFER: 4}))
    (refusal,) = found.refusals
    assert STIFFER.title in refusal
    assert found.keeps(TEST)


def test_a_longer_time_between_false_alarms_has_a_higher_limit_and_a_longer_delay():
    points = judged(traces(seed=1), every=[100.0, 1000.0, 10000.0], chart="cusum")
    limits = [point.limit.value for point in points]
    medians = [point.delays[-1].median.value for point in points]
    assert limits == sorted(limits)
    assert medians == sorted(medians)


def test_a_chart_watches_the_direction_that_the_score_states():
    """A leak raises it; falling scores raise no alarm unless the chart is asked to look both ways."""
    whole = traces()
    fallen = replace(whole, values=4e-6 - whole.values)
    assert judged(whole)[0].delays[-1].n_found == 40
    assert judged(fallen)[0].delays[-1].n_found < 20
    assert judged(fallen, direction="both")[0].delays[-1].n_found == 40
