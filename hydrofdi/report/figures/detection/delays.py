"""The delay after the onset of a leak over the time between false alarms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.scores import Population
from hydrofdi.report.detection.wording import severity_unit
from hydrofdi.report.figures.detection.marks import panels
from hydrofdi.report.figures.style import MARKERS, log_axis, series
from hydrofdi.report.run_lengths import hours
from hydrofdi.studies.charts import ChartJudgement, RunLengths


def draw_delays(lengths: RunLengths) -> Any:
    """A panel for each leak, a line for each chart.

    Raises
    ------
    ReportError
        No delay is stated.
    """
    levels = list(dict.fromkeys(delay.population for chart in lengths.charts for delay in chart.delays))
    if not levels:
        raise ReportError("no leak sets in while a chart watches")
    labels = list(dict.fromkeys(chart.label for chart in lengths.charts))
    marks = [{"marker": MARKERS[place % len(MARKERS)], "markersize": 3.5} for place in range(len(labels))]
    styles = {label: series(k, len(labels)) | marks[k] for k, label in enumerate(labels)}
    figure, axes = panels(len(levels), 4, width=2.6, height=2.6, sharex=True, sharey=True)
    unit, every = severity_unit(lengths), [hours(chart.false_alarm_every) for chart in lengths.charts]
    for axis, level in zip(axes, levels, strict=True):
        for label, style in styles.items():
            _draw_line(axis, [chart for chart in lengths.charts if chart.label == label], level, style)
        axis.set_title(unit.text(level.severity))
        axis.set_xlim(min(every) / 1.5, max(every) * 1.5)
        log_axis(axis.xaxis)
    axes[0].set_ylim(bottom=0.0)
    figure.supxlabel("mean time between false alarms that is asked for [h]", fontsize=9)
    figure.supylabel("median delay [s]", fontsize=9)
    handles = [Line2D([], [], label=label, **style) for label, style in styles.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    return figure


def _draw_line(axis: Any, charts: Sequence[ChartJudgement], level: Population, style: dict[str, Any]) -> None:
    """Delays of a leak over the time between false alarms, ascending."""
    known = sorted(
        (
            hours(chart.false_alarm_every),
            delay.median.value,
            delay.median.low,
            min(delay.median.high, delay.watched),
        )
        for chart in charts
        for delay in chart.delays
        if delay.population == level and np.isfinite(delay.median.value)
    )
    every, medians, low, high = np.array(known).reshape(-1, 4).T
    axis.plot(every, medians, **style)
    axis.fill_between(every, low, high, color=style["color"], alpha=0.18, linewidth=0)
