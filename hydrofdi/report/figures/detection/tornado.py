"""Tornado: what each nuisance moves a healthy score by, expressed as the leak that would do the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.sensitivity import Reach
from hydrofdi.report.detection.populations import (
    TOGETHER,
    end,
    foremost_nuisances,
    shown_nuisances,
    tested_range,
)
from hydrofdi.report.detection.wording import SeverityUnit, severity_unit
from hydrofdi.report.figures.detection.marks import panels
from hydrofdi.report.figures.style import BLUE, INK, ORANGE
from hydrofdi.settings.readable import two_digits
from hydrofdi.studies.records import Detection

_MOST_PANELS, _MOST_ROWS = 6, 8
_STUB, _START = 0.12, 0.3
"""Decades: length of a bar that stays below the tested leaks, and where these begin."""


def draw_tornado(detection: Detection) -> Any:
    """Leaks that each nuisance imitates (right) and hides (left), a panel for each score.

    Raises
    ------
    ReportError
        The study has no records for it, or no leak moves a score.
    """
    tested, unit = tested_range(detection), severity_unit(detection)
    shown = [
        (name, [(label, reach) for label, _, reach in foremost_nuisances(own, _MOST_ROWS) if reach])
        for name, own in shown_nuisances(detection)
        if own.together
    ][:_MOST_PANELS]
    if tested is None or not shown:
        raise ReportError("no nuisance can be expressed as a leak: set study.sensitivity.alone, and leaks")
    height = 0.9 + 0.2 * max(len(rows) for _, rows in shown)
    figure, axes = panels(len(shown), 2, width=4.4, height=height)
    for axis, (name, rows) in zip(axes, shown, strict=True):
        _draw_panel(axis, name, rows, tested)
        _ticks(axis, tested, unit)
    figure.supxlabel(
        f"← {unit.quantity} that is hidden          {unit.quantity} that a healthy record looks like →"
        f"  {unit.bracket}",
        fontsize=9,
    )
    return figure


def _draw_panel(axis: Any, name: str, rows: Sequence[tuple[str, Reach]], tested: tuple[float, float]) -> None:
    for row, (label, reach) in enumerate(rows):
        for sign, fault, color in ((1.0, reach.imitated, ORANGE), (-1.0, reach.hidden, BLUE)):
            faded = 0.45 if label == TOGETHER else 0.9
            axis.barh(row, sign * _place(end(fault), tested), height=0.62, color=color, alpha=faded)
            ends = [sign * _place(limit, tested) for limit in (fault.low, fault.high)]
            axis.plot(ends, [row, row], color=INK, linewidth=0.8)
    axis.set_yticks(range(len(rows)), [label for label, _ in rows], fontsize=7.5)
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.axvline(0.0, color=INK, linewidth=0.6)
    axis.grid(visible=False, axis="y")
    axis.set_title(name, fontsize=8.5)


def _place(severity: float, tested: tuple[float, float]) -> float:
    """Decades from where the tested leaks begin; what is smaller or larger than these lies outside."""
    if severity == 0.0:
        return _STUB
    end = _START + math.log10(tested[1] / tested[0])
    return min(_START + math.log10(severity / tested[0]), end) if math.isfinite(severity) else end + _START


def _ticks(axis: Any, tested: tuple[float, float], unit: SeverityUnit) -> None:
    first, last = map(unit.value, tested)
    decades = range(math.ceil(math.log10(first) - 1e-9), math.floor(math.log10(last) + 1e-9) + 1)
    severities = [10.0**decade / unit.value(1.0) for decade in decades]
    places = [(_place(severity, tested), two_digits(unit.value(severity))) for severity in severities]
    marks = [(sign * place, text) for place, text in places for sign in (-1.0, 1.0)]
    axis.set_xticks([place for place, _ in marks], [text for _, text in marks])
    widest = _place(math.inf, tested)
    axis.set_xlim(-widest - 0.05, widest + 0.05)
    for place in (-_START, _START, _START - widest, widest - _START):
        axis.axvline(place, color=INK, linewidth=0.4, linestyle=":")
