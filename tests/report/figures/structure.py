"""A figure as plain data, to compare what it shows without its pixels."""

from __future__ import annotations

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

from hydrofdi.report.figures.style import SETTINGS

DPI = 100


def drawn(figure):
    """The figure, laid out as it is saved."""
    figure.dpi = DPI
    with matplotlib.rc_context(SETTINGS):
        FigureCanvasAgg(figure).draw()
    return figure


def tick_labels(axis):
    """Labels of ticks that stand within the axis and are shown."""
    if not (axis.get_visible() and axis.axes.get_visible()):
        return []
    ends = sorted(axis.get_view_interval())
    margin = 1e-9 * (ends[1] - ends[0])
    ticks = [
        tick for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]
        if ends[0] - margin <= tick.get_loc() <= ends[1] + margin
    ]  # fmt: skip
    labels = [
        label
        for tick in sorted(ticks, key=lambda tick: tick.get_loc())
        for label in (tick.label1, tick.label2)
    ]
    return [label for label in labels if label.get_visible() and label.get_text().strip()]


def structure(figure):
    """Axes with titles, labels, ticks, series and cells, legends, and the texts of the figure."""
    drawn(figure)
    return {
        "legends": [legend_texts(legend) for legend in figure.legends],
        "texts": sorted(text.get_text() for text in figure.texts),
        "axes": [axes_structure(axis) for axis in figure.axes],
    }


def axes_structure(axis):
    legend = axis.get_legend()
    described = {
        "title": axis.get_title(loc="left"),
        "x": axis_structure(axis.xaxis),
        "y": axis_structure(axis.yaxis),
        "series": [line_structure(line) for line in axis.lines if not line.get_label().startswith("_")],
        "lines": len(axis.lines),
        "bars": len(axis.patches),
        "bands": len(axis.collections),
        "cells": [list(image.get_array().shape) for image in axis.images],
        "texts": [] if axis.images else [text.get_text() for text in axis.texts],
        "legend": legend_texts(legend) if legend else [],
    }
    return {key: value for key, value in described.items() if value}


def axis_structure(axis):
    labels = [label.get_text() for label in tick_labels(axis)]
    return {"label": axis.get_label().get_text(), "scale": axis.get_scale(), "ticks": labels}


def line_structure(line):
    return {
        "name": line.get_label(),
        "color": to_hex(line.get_color()),
        "marker": str(line.get_marker()),
        "points": len(line.get_xdata()),
    }


def legend_texts(legend):
    return [text.get_text() for text in (legend.get_title(), *legend.get_texts()) if text.get_text()]
