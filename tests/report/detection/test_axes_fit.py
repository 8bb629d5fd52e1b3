"""Figures of rates and densities use their room: limits from the data, arrows for what lies beyond."""

from __future__ import annotations

import pytest

from hydrofdi.evaluation.populations import Kind
from hydrofdi.report.figures import draw_figure
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.rules import Rules
from tests.report.detection.made_up import P1, made_up_records, made_up_score, report_of


def study(gain, shift=0.0, **chosen):
    records = made_up_records(**chosen)
    return detect(records, [made_up_score(records, "one", gain=gain, shift=shift, channels=(P1,))], Rules())


@pytest.mark.parametrize("shift", [0.0, 1.0, 9.0])
def test_the_axis_of_false_alarms_ends_behind_the_largest_interval(shift):
    detection = study(50.0, shift)
    (axis,) = draw_figure(report_of(detection), "false_alarms").axes
    highest = 100.0 * max(rate.high for rate in detection.judgements[0].false_alarms.values())
    assert highest <= axis.get_xlim()[1] <= max(1.2 * highest, 2.5)
    ticks = axis.get_xticks()
    assert len(ticks) >= 3
    assert max(ticks) <= axis.get_xlim()[1]


def test_densities_show_scores_beyond_the_axis_as_a_share():
    detection = study(200.0, severities=(0.001, 0.01, 0.1, 0.3, 1.0))
    (axis,) = draw_figure(report_of(detection), "densities").axes
    assert [text.get_text() for text in axis.texts].count("100 % →") == 2
    assert len(axis.patches) == 2 * (len(detection.records.populations) - 2), "no bar of what lies beyond"


def test_densities_show_every_tested_level_of_a_usual_study():
    detection = study(200.0, severities=(0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0))
    (axis,) = draw_figure(report_of(detection), "densities").axes
    labels = {label.get_text() for label in axis.get_yticklabels()}
    assert {each.name for each in detection.records.populations if each.kind is Kind.FAULT} <= labels
