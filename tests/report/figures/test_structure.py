"""What figures show, compared by structure."""

import matplotlib
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

from hydrofdi.report.figures import (
    COLORS,
    LINES,
    MARKERS,
    SETTINGS,
    draw_all,
    draw_figure,
    figure_bytes,
    series,
)
from tests.report.rows import check_golden

COMPARED = [
    ("modes", "sensitivity"), ("many", "responses"), ("study", "answer"), ("study", "ranking"),
    ("study", "pod"), ("delays", "delays"),
]  # fmt: skip


@pytest.mark.parametrize(("experiment", "name"), COMPARED)
def test_a_figure_shows_what_it_did(reports, experiment, name):
    check_golden(f"{experiment}-{name}.txt", structure(draw_figure(reports[experiment], name)))


def test_every_figure_can_be_drawn_and_saved(reports):
    owners = {name: report for report in reversed(reports.values()) for name in report.figures()}
    compared = {name for _, name in COMPARED}
    for name in owners.keys() - compared:
        drawn, holes = draw_all(owners[name], [name])
        assert figure_bytes(drawn[name], "svg"), holes


def structure(figure):
    """Axes with titles, labels, ticks, series and cells, legends, and texts, laid out as it is saved."""
    figure.dpi = 100
    with matplotlib.rc_context(SETTINGS):
        FigureCanvasAgg(figure).draw()
    texts = [legend_texts(legend) for legend in figure.legends] + [text.get_text() for text in figure.texts]
    return texts + [axes_structure(axis) for axis in figure.axes]


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
        "cells": [image.get_array().shape for image in axis.images],
        "texts": [] if axis.images else [text.get_text() for text in axis.texts],
        "legend": legend_texts(legend) if legend else [],
    }
    return {key: value for key, value in described.items() if value}


def axis_structure(axis):
    """Label, scale, and the labels of ticks that stand within the axis and are shown."""
    low, high = sorted(axis.get_view_interval())
    margin, shown = 1e-9 * (high - low), axis.get_visible() and axis.axes.get_visible()
    ticks = [tick for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()] if shown]
    inside = [tick for tick in ticks if low - margin <= tick.get_loc() <= high + margin]
    labels = [
        label.get_text()
        for tick in sorted(inside, key=lambda tick: tick.get_loc())
        for label in (tick.label1, tick.label2)
        if label.get_visible() and label.get_text().strip()
    ]
    return axis.get_label().get_text(), axis.get_scale(), " ".join(labels)


def line_structure(line):
    return line.get_label(), to_hex(line.get_color()), str(line.get_marker()), len(line.get_xdata())


def legend_texts(legend):
    return [text.get_text() for text in (legend.get_title(), *legend.get_texts()) if text.get_text()]


def test_eight_series_differ_in_colour_in_line_and_in_marker():
    assert [len({str(each) for each in looks}) for looks in (COLORS, LINES, MARKERS)] == [8, 8, 8]
    many = [series(place) for place in range(12)]
    assert len({(str(each["color"]), str(each["linestyle"])) for each in many}) == 12
