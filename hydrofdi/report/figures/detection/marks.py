"""How scores are distinguished: a colour and a marker for each set of sensors."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

from hydrofdi.errors import ReportError
from hydrofdi.report.detection.selection import foremost
from hydrofdi.report.detection.wording import sensors
from hydrofdi.report.figures.style import COLORS, MARKERS
from hydrofdi.studies.judgement import Detection, Judgement


def sensor_marks(detection: Detection, shown: Sequence[Judgement]) -> dict[str, dict[str, Any]]:
    """Sets of sensors of the shown scores → colour and marker, which are the same in all figures.

    The largest set of the study comes first; all beyond seven have the last mark.
    """
    found = {sensors(each): len(each.scored.channels) for each in detection.judgements}
    ordered = sorted(found, key=lambda name: (-found[name], name))
    last = len(COLORS) - 1
    return {
        name: {"color": COLORS[min(place, last)], "marker": MARKERS[min(place, last)]}
        for place, name in enumerate(ordered)
        if name in {sensors(each) for each in shown}
    }


def with_threshold(detection: Detection, most: int) -> tuple[Judgement, ...]:
    """The foremost scores that have a threshold.

    Raises
    ------
    ReportError
        No score has a threshold.
    """
    shown = tuple(each for each in foremost(detection, most) if each.threshold is not None)
    shown = shown or tuple(each for each in detection.judgements if each.threshold is not None)[:most]
    if not shown:
        raise ReportError("no score has a threshold")
    return shown


def titled(judgement: Judgement, width: int = 30) -> str:
    """Name and sensors over a panel; a long name is broken after its dot, then after underscores."""
    name, needs = judgement.scored.name, sensors(judgement)
    if len(name) > width:
        head, dot, tail = name.partition(".")
        parts = [head + dot, *wrap(tail.replace("_", "_ "), width)]
        name = "\n".join(part.replace("_ ", "_") for part in parts)
    return name if f"({needs})" in name else f"{name}\n({needs})"


def panels(count: int, columns: int, *, width: float, height: float, **shared: Any) -> tuple[Any, list[Any]]:
    """A figure with `count` panels in rows, and the panels.

    Parameters
    ----------
    count, columns : int
    width, height : float
        Of a panel [in].
    **shared : Any
        ``sharex`` and ``sharey``.
    """
    from matplotlib.figure import Figure

    columns = min(count, columns)
    rows = -(-count // columns)
    figure = Figure(figsize=(max(width * columns, 9.0), height * rows + 0.4), layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False, **shared).flat)
    for axis in axes[:count]:
        axis.tick_params(labelsize=7.5)
    for axis in axes[count:]:
        axis.remove()
    return figure, axes[:count]
