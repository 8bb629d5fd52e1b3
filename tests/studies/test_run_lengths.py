"""Charts on traces whose run lengths and delays are known; what they may see, and what not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtri

from hydrofdi.config.study import OnlineConfig, WatchedChart
from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction
from hydrofdi.report.detection.sections import answer_block, run_lengths_block
from hydrofdi.studies.detecting import Traces, judge_chart
from hydrofdi.studies.records import Detection
from tests.commands import run, run_json
from tests.studies.populations import FIT, LEVELS, STIFFER, TEST, study

SMALL, LARGE = LEVELS[0], LEVELS[-1]
INTERVAL, N_INSTANT, ONSET, EVERY = 0.5, 200, 50.0, 1000.0
LATENT = 3
"""Instants between the onset and the rise of a leak."""


def traces(sizes=None, unit=2e-6, seed=0):
    """Independent normal scores of centre `unit` and spread `unit`; a leak adds its severity times ten."""
    records = study(sizes or {FIT: 200, TEST: 100, SMALL: 40, LARGE: 40, STIFFER: 40})
    time = 2.0 + INTERVAL * np.arange(N_INSTANT)
    scores = np.random.default_rng(seed).normal(size=(records.of_record.size, N_INSTANT))
    rises = time >= ONSET + LATENT * INTERVAL
    scores += 10.0 * np.where(records.severity > 0.0, records.severity, 0.0)[:, None] * rises
    onset = np.where(records.severity > 0.0, ONSET, np.nan)
    flow = records.severity.copy()
    return Traces(records, unit * (1.0 + scores), time, onset, flow, "m^3/s", Direction.RISING)


def judged(of, every=EVERY, chart="ewma", **options):
    options = {"weight": 1} | options if chart == "ewma" else options
    asked = WatchedChart(of="made.up", chart=chart, options=options)
    online = OnlineConfig(false_alarm_every=every, charts={"own": asked})
    return list(judge_chart(of, "own", asked, online, Rules()))


def told(of, **options):
    """What is found in each population at the one limit."""
    (found,) = judged(of, **options)
    return {each.population: each.found for each in found.outcomes}


def n_found(delays):
    return int(np.isfinite(delays.values).sum())


def test_a_plain_limit_is_the_quantile_of_the_wanted_run_length_and_finds_a_leak_as_its_score_rises():
    """Independent scores exceed it once in so many, in fit records and in those that no limit saw."""
    (found,) = judged(traces())
    assert (found.centre, found.spread) == pytest.approx((2e-6, 2e-6), rel=0.03)
    assert found.limit.value == pytest.approx(ndtri(1.0 - INTERVAL / EVERY), abs=0.3)
    tested, stiffer, small, large = (each.found for each in found.outcomes)
    assert tested.duration == pytest.approx(100 * N_INSTANT * INTERVAL)
    assert tested.low < EVERY < tested.high
    assert found.keeps(tested)
    assert stiffer.duration < tested.duration
    assert [*found.delays] == [SMALL, LARGE]
    assert n_found(large) == large.values.size == 40
    assert large.quantile(0.5).value == large.quantile(0.9).value == pytest.approx(LATENT * INTERVAL)
    assert small.quantile(0.5).value > large.quantile(0.5).value
    assert found.outcomes[-1].severity == pytest.approx(1.0, rel=0.02)
    assert large.watched == pytest.approx(2.0 + INTERVAL * (N_INSTANT - 1) - ONSET)


def test_test_records_do_not_move_the_limit():
    whole = traces()
    is_fit = (whole.records.of_record == whole.records.populations.index(FIT))[:, None]
    (before,) = judged(whole)
    (others,) = judged(replace(whole, values=np.where(is_fit, whole.values, 5.0 * whole.values)))
    (own,) = judged(replace(whole, values=np.where(is_fit, 5.0 * whole.values, whole.values)))
    assert (others.limit, others.centre, others.spread) == (before.limit, before.centre, before.spread)
    assert own.spread == pytest.approx(5.0 * before.spread)
    assert others.outcomes[0].found.n_alarm > before.outcomes[0].found.n_alarm


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
    before, after = told(whole), told(replace(whole, **changed))
    assert [*map(repr, before.values())] == [*map(repr, after.values())]


def test_alarms_before_the_onset_are_false_ones_and_no_detections():
    whole = traces()
    (row, *_) = whole.records.rows(SMALL)
    values = whole.values.copy()
    values[row, :3] = 1.0
    values[row, whole.time >= ONSET] = 0.0
    before, after = (told(each)[SMALL] for each in (whole, replace(whole, values=values)))
    assert after.n_early.sum() == before.n_early.sum() + 3
    assert n_found(after) <= n_found(before)
    assert after.values.size == before.values.size


def test_leaks_from_the_start_and_failed_runs_have_no_delay_and_a_diverged_estimator_finds_nothing():
    whole = traces()
    large = whole.records.rows(LARGE)
    onset, flow, values = whole.onset.copy(), whole.flow.copy(), whole.values.copy()
    onset[whole.records.rows(SMALL)] = np.nan
    flow[large[:10]] = np.nan
    values[large[10:15], N_INSTANT // 4 :] = np.nan
    found = told(replace(whole, onset=onset, flow=flow, values=values))
    assert SMALL not in found
    assert (found[LARGE].values.size, n_found(found[LARGE]), found[LARGE].not_measurable) == (30, 25, 5)


def test_too_little_time_is_no_verdict_without_many_alarms_and_no_limit():
    few = traces({FIT: 200, TEST: 20, LARGE: 5})
    short, long = judged(few, every=[EVERY, 1e5])
    tested = short.outcomes[0].found
    assert short.keeps(tested) is None
    assert tested.duration < 3.0 * EVERY
    assert (long.limit, len(long.refusals), long.outcomes) == (None, 1, ())
    values = few.values.copy()
    values[few.records.rows(TEST)] *= 3.0
    (found,) = judged(replace(few, values=values))
    assert found.keeps(found.outcomes[0].found) is False
    shown = [Detection(few.records, (), Rules(), charts=(each,)) for each in (short, found)]
    first, second = (str(answer_block(each)) for each in shown)
    assert "1 of 1 tests of their limits" in second
    assert "tests of their limits" not in first


def test_too_few_records_of_a_shift_concern_this_shift_alone():
    (found,) = judged(traces({FIT: 200, TEST: 100, LARGE: 40, STIFFER: 4}))
    (refusal,) = found.refusals
    assert STIFFER.title in refusal
    assert found.keeps(found.outcomes[0].found)


def test_a_longer_time_between_false_alarms_has_a_higher_limit_and_a_longer_delay():
    points = judged(traces(seed=1), every=[100.0, 1000.0, 10000.0], chart="cusum")
    for row in zip(*((each.limit.value, each.delays[LARGE].quantile(0.5).value) for each in points),
                   strict=True):  # fmt: skip
        assert list(row) == sorted(row)


def test_a_chart_watches_the_direction_that_the_score_states():
    """Falling scores raise no alarm unless the chart is asked to look both ways."""
    fallen = replace(traces(), values=4e-6 - traces().values)
    assert n_found(told(fallen)[LARGE]) < 20
    assert n_found(told(fallen, direction="both")[LARGE]) == 40


def block(every):
    of = traces()
    charts = [*judged(of, every)]
    charts += [replace(chart, label="sums") for chart in judged(of, every, chart="cusum", shift=4)]
    return run_lengths_block(Detection(of.records, (), Rules(), charts=tuple(charts)))


def test_delays_have_their_interval_and_a_chart_without_a_limit_its_reason():
    found = block([EVERY, 1e6])
    delays, alarms, refused = found.tables
    (own,) = [row for row in delays if (row["chart"], row["population"]) == ("own", LARGE.name)]
    assert [own[f"delay_median{end}_s"] for end in ("", "_low", "_high")] == [1.5] * 3
    assert alarms["false_alarm_every_h"] == pytest.approx(EVERY / 3600.0)
    assert {(row["chart"], round(row["false_alarm_every_h"])) for row in refused} == {
        ("own", 278),
        ("sums", 278),
    }
    assert found.figures
    assert not block(1e6).figures


SMOKE = Path(__file__).parents[2] / "configs" / "delays" / "smoke.yaml"


def test_a_chart_on_sensors_that_a_machine_lacks_is_left_out(tmp_path):
    small = ["--set", "study.healthy={fit: 5, test: 5, shift: 5}", "--set", "study.faults.each=1"]
    sensors = ["--set", "detection.sensors=[P1]"]
    run("sweep", SMOKE, *small, *sensors, "--out", tmp_path / "out", "--engine", "in-process", check=0)
    shown = run_json("report", tmp_path / "out")
    assert shown["run_lengths"] == []
    assert any("weak_rls is left out" in remark for remark in shown["studies"][0]["remarks"])
