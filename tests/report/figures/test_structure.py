"""What figures show, compared by structure with ``golden/``. HYDROFDI_WRITE_GOLDEN=1 writes that anew."""

import json
import os
from pathlib import Path

import matplotlib
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

import hydrofdi
from hydrofdi.records import Channel, RecordBatch
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
from hydrofdi.report.figures.signals import draw_record

GOLDEN = Path(__file__).parent / "golden"

COMPARED = [
    ("modes", "sensitivity"),
    ("many", "responses"),
    ("study", "answer"),
    ("study", "ranking"),
    ("study", "pod"),
    ("delays", "delays"),
]


@pytest.mark.parametrize(("experiment", "name"), COMPARED)
def test_a_figure_shows_what_it_did(reports, experiment, name):
    found = structure(draw_figure(reports[experiment], name))
    golden = GOLDEN / f"{experiment}-{name}.json"
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        GOLDEN.mkdir(exist_ok=True)
        golden.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert found == json.loads(golden.read_text(encoding="utf-8"))


def test_every_figure_can_be_drawn_and_saved(reports):
    owners = {name: report for report in reversed(reports.values()) for name in report.figures()}
    compared = {name for _, name in COMPARED}
    for name in owners.keys() - compared:
        drawn, holes = draw_all(owners[name], [name])
        assert figure_bytes(drawn[name], "svg"), holes


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


def test_eight_series_differ_in_colour_in_line_and_in_marker():
    assert [len({str(each) for each in looks}) for looks in (COLORS, LINES, MARKERS)] == [8, 8, 8]
    many = [series(place, 12) for place in range(12)]
    assert len({(str(each["color"]), str(each["linestyle"])) for each in many}) == 12


def test_runs_and_records_can_be_drawn():
    run = hydrofdi.simulate({"record": {"duration": "4 s"}, "control": {"law": "pi"}})
    assert figure_bytes(run.plot(), "png")
    dataset = hydrofdi.simulate(duration="4 s").to_xarray()
    names = ("chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage")
    channels = {Channel(name): dataset[name].values[None, :] for name in names}
    record = RecordBatch(channels, 500.0, ("made",))
    assert figure_bytes(draw_record(record), "png")
