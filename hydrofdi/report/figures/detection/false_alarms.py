"""Alarms of records whose seal is sound."""

from __future__ import annotations

from typing import Any

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.selection import tested
from hydrofdi.report.detection.wording import sensors
from hydrofdi.report.figures.detection.marks import (
    panels,
    root_percent_axis,
    sensor_marks,
    titled,
    with_threshold,
)
from hydrofdi.report.figures.style import INK, PAPER
from hydrofdi.studies.judgement import Detection, Judgement

_MOST = 6


def draw_false_alarms(detection: Detection) -> Any:
    """Rates of healthy test records, shifts and confusions, a panel for each of the foremost scores.

    Raises
    ------
    ReportError
        There are no such records, or no score has a threshold.
    """
    shown = with_threshold(detection, _MOST)
    populations = tested(detection, Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION)
    if not populations:
        raise ReportError("no record with a healthy seal is tested")
    marks = sensor_marks(detection, shown)
    height = 0.8 + 0.24 * len(populations)
    figure, axes = panels(len(shown), 3, width=3.0, height=height, sharex=True, sharey=True)
    rates = [rate for each in shown for one, rate in each.false_alarms.items() if one in populations]
    highest = max([2.0 * detection.rules.false_alarm_rate, *(rate.high for rate in rates if rate.total)])
    for axis, judgement in zip(axes, shown, strict=True):
        root_percent_axis(axis, 100.0 * highest)
        for row, population in enumerate(populations):
            _draw_rate(axis, row, judgement, population, marks[sensors(judgement)])
        axis.axvline(100.0 * detection.rules.false_alarm_rate, color=INK, linewidth=0.9)
        axis.set_title(titled(judgement), fontsize=8.5)
    axes[0].set_yticks(range(len(populations)), [population.name for population in populations], fontsize=8)
    axes[0].set_ylim(len(populations) - 0.4, -0.6)
    figure.supxlabel("records that raise an alarm [%]", fontsize=9)
    return figure


def _draw_rate(
    axis: Any, row: int, judgement: Judgement, population: Population, mark: dict[str, Any]
) -> None:
    rate = judgement.false_alarms.get(population)
    if rate is None or not rate.total:
        return
    face = {"markerfacecolor": PAPER} if population in judgement.counted else {}
    axis.plot([100.0 * rate.low, 100.0 * rate.high], [row, row], color=mark["color"], linewidth=1.2)
    axis.plot(100.0 * rate.value, row, **mark, **face, markersize=5, linestyle="none", clip_on=False)
