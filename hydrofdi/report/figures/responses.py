"""Response of each feature to each varied parameter: small panels of medians and ranges."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.report.figures.style import BLUE, log_axis
from hydrofdi.report.responses import AGAINST, RANGES, Axis, AxisResponses, Response, ResponseStudy

_MOST_AXES, _MOST_FEATURES = 6, 8
_WIDTH, _HEIGHT = 2.4, 1.25
_LABEL, _LETTERS = 7.5, 20
"""Size of the labels of features [pt], and the letters of it in a panel, with blanks at breaks."""

_DECADES = 30.0
"""An axis is logarithmic if the ratio of its values is at least this."""


def draw_responses(study: ResponseStudy) -> Figure:
    """A row for each feature, a column for each parameter.

    Raises
    ------
    ReportError
        Nothing varies, or no feature is measured.
    """
    found = [each for each in study.axes if each.responses]
    if not found:
        raise ReportError("the runs do not differ in any parameter of the sweep")
    axes = sorted(
        _largest(found, [max(one.reach for one in each.responses) for each in found], _MOST_AXES),
        key=found.index,
    )
    names = list(dict.fromkeys(one.feature.header for each in axes for one in each.responses))
    moved = [max(one.reach for one in _named(axes, name)) for name in names]
    shown = sorted(_largest(names, moved, _MOST_FEATURES), key=names.index)
    size = (max(_WIDTH * len(axes) + 0.8, 5.0), _HEIGHT * len(shown) + 1.6)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(shown), len(axes), sharex="col", sharey="row", squeeze=False)
    for column, each in enumerate(axes):
        _draw_column(grid[:, column], each, shown)
    for panel, name in zip(grid[:, 0], shown, strict=True):
        panel.set_ylabel(_label(name), fontsize=_LABEL)
    figure.align_ylabels(grid[:, 0])
    note = fill(_note(axes, len(found), len(shown), len(names)), round(size[0] / 0.068))
    figure.supxlabel(note, fontsize=8, x=0.01, ha="left")
    return figure


def _label(name: str) -> str:
    """The name and unit of a feature on lines that are no longer than a panel is high."""
    words = (name if "[" in name else f"{name} [–]").split(" [")
    broken = [fill(part.replace("_", "_ ").replace(".", ". "), _LETTERS) for part in words]
    return "\n[".join(broken).replace("_ ", "_").replace(". ", ".")


def _largest(items: Sequence[Any], sizes: Sequence[float], most: int) -> list[Any]:
    """Those of the largest sizes."""
    order = sorted(range(len(items)), key=lambda place: -sizes[place])
    return [items[place] for place in order[:most]]


def _named(axes: Sequence[AxisResponses], name: str) -> list[Response]:
    return [one for each in axes for one in each.responses if one.feature.header == name]


def _draw_column(panels: Any, responses: AxisResponses, shown: Sequence[str]) -> None:
    places, labels = _places(responses.axis)
    by_name = {one.feature.header: one for one in responses.responses}
    for panel, name in zip(panels, shown, strict=True):
        if name in by_name:
            over = by_name[name].over
            low, high = [spread.low for spread in over], [spread.high for spread in over]
            panel.fill_between(places, low, high, color=BLUE, alpha=0.2, linewidth=0)
            panel.plot(places, [spread.median for spread in over], color=BLUE, marker="o", markersize=3.5)
    _mark_values(panels[-1], places, labels)
    panels[-1].set_xlabel(
        responses.axis.header if "[" in responses.axis.header or labels else f"{responses.axis.header} [–]"
    )
    if responses.against:
        panels[0].set_title(fill(f"δ against {AGAINST[responses.against]}", 32), fontsize=8)


def _places(axis: Axis) -> tuple[list[float], list[str]]:
    """Where the groups stand, and their names where they are words, or reach from nothing over decades."""
    count = [float(place) for place in range(len(axis.groups))]
    if axis.numbers is None:
        return count, [group.text for group in axis.groups]
    middles = [float(np.nanmedian(axis.numbers[group.rows])) for group in axis.groups]
    places = [0.0 if middle == 0.0 else float(axis.text(middle)) for middle in middles]
    positive = [place for place in places if place > 0.0]
    if positive and max(positive) >= _DECADES * min(positive) and len(positive) < len(places):
        return count, [group.text for group in axis.groups]
    return places, []


def _mark_values(panel: Any, places: Sequence[float], labels: Sequence[str]) -> None:
    if labels:
        is_long = len(labels) * (2 + max(map(len, labels))) > 34
        panel.set_xticks(places, labels, **({"rotation": 40, "ha": "right"} if is_long else {}))
        panel.margins(x=0.1)
    elif min(places) > 0.0 and max(places) >= _DECADES * min(places):
        log_axis(panel.xaxis)
    else:
        panel.locator_params(axis="x", nbins=5)
        panel.xaxis.set_major_formatter("{x:g}")


def _note(axes: Sequence[AxisResponses], n_axis: int, n_feature: int, n_all: int) -> str:
    note = f"Line: median of the runs with this value; band: {RANGES}"
    if len(axes) < n_axis:
        note += f". Shown are the {len(axes)} of {n_axis} parameters that move a feature most"
    if n_feature < n_all:
        note += f". Shown are the {n_feature} of {n_all} features that move most; the tables have all"
    return note
