"""The chart of a detector sees judged windows alone, and a leak raises it whichever way the score goes."""

import numpy as np
import pytest

from hydrofdi.detectors.registry import make_chart
from hydrofdi.detectors.trained.charting import ScoreChart
from hydrofdi.detectors.trained.configuration import ChartConfig, DetectorConfig
from hydrofdi.detectors.trained.file import ChartLimit, Made
from hydrofdi.detectors.trained.judging import Verdict
from hydrofdi.detectors.trained.training import train
from hydrofdi.errors import Issue
from tests.detectors.trained.healthy import Records
from tests.detectors.trained.made import detector

SCORES = 10.0 + 2.0 * np.random.default_rng(5).standard_normal(60) + np.repeat([0.0, 3.0], 30)
OPTIONS = {"direction": "rising"}


def charted(direction="rising", limit=6.0, name="cusum"):
    bound = {"rising": (None, 1e9), "falling": (-1e9, None)}[direction]
    file = detector(limits=bound, scale=(10.0, 2.0), direction=direction)
    chart = ChartConfig(chart=name, options=OPTIONS)
    limits = ChartLimit(limit=limit, mean_time=None, interval=(0.0, None), hours=1.0)
    config = file.config.model_copy(update={"chart": chart})
    return file.model_copy(update={"config": config, "chart": limits})


def readings(chart, verdicts):
    state, found = chart.start(), []
    for verdict in verdicts:
        state, reading = chart.step(state, verdict)
        found.append(reading)
    return found


def judged(scores):
    return [Verdict(score, False, 1.0) for score in scores.tolist()]


@pytest.mark.parametrize(("direction", "scores"), [("rising", SCORES), ("falling", 20.0 - SCORES)])
def test_it_is_the_chart_of_standardised_scores(direction, scores):
    found = readings(ScoreChart(charted(direction)), judged(scores))
    expected = make_chart("cusum", OPTIONS).follow((SCORES - 10.0)[None] / 2.0, 6.0)[0]
    np.testing.assert_array_equal([reading.statistic for reading in found], expected)
    assert [reading.alarm for reading in found] == (expected >= 6.0).tolist()
    assert any(reading.alarm for reading in found[30:])
    assert not any(reading.alarm for reading in found[:30])


def test_what_is_not_judged_passes_it_by():
    novel = Verdict(1e6, None, None, Issue("is novel", kind="novel"))
    lost = Verdict(None, None, None, Issue("is missing", kind="missing"))
    mixed = [each for verdict in judged(SCORES) for each in (novel, verdict, lost)]
    found = readings(ScoreChart(charted()), mixed)
    assert found[1::3] == readings(ScoreChart(charted()), judged(SCORES))
    assert all(reading.statistic is None and not reading.alarm for reading in found[::3] + found[2::3])


def test_healthy_records_of_a_day_set_up_a_chart_unless_none_is_wanted():
    means = np.random.default_rng(5).standard_normal((20, 5))
    number = {"indicator": "pressure_statistics", "output": "mean", "direction": "both"}
    for frequency, given, has_chart in ((0.004, {}, True), (0.004, {"chart": None}, False), (4.0, {}, False)):
        window = {"window": {"duration": 4.0 / frequency}}
        config = DetectorConfig.model_validate({**number, **window, "false_alarm_rate": 0.1, **given})
        records = Records(means, sampling_frequency=frequency)
        file = train(records, config, ["records"], Made(hydrofdi="1", time="now"))
        assert (file.chart is not None) is has_chart
        assert file.config.chart is None or file.config.chart.false_alarm_every == 86400.0
