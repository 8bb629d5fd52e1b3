"""What every figure keeps, read from the drawn figure."""

from __future__ import annotations

import io
from itertools import combinations

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from PIL import Image

from hydrofdi.report.figures.contrast import contrast
from hydrofdi.report.figures.style import PAPER, SETTINGS

DPI = 100


def drawn(figure):
    """The figure, laid out as it is saved."""
    figure.dpi = DPI
    with matplotlib.rc_context(SETTINGS):
        FigureCanvasAgg(figure).draw()
    return figure


def faults(figure):
    """A sentence on each law that a figure breaks."""
    drawn(figure)
    laws = (
        cut_texts, overlapping_texts, covered_data, faint_texts, alike_series, unnamed_axes, repeated_ticks
    )  # fmt: skip
    return [fault for law in laws for fault in law(figure)]


def texts(figure):
    """Visible texts that are not empty."""
    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    ticks = {
        id(label) for axis in figure.axes for each in (axis.xaxis, axis.yaxis) for label in all_labels(each)
    }
    seen = {
        id(label) for axis in figure.axes for each in (axis.xaxis, axis.yaxis) for label in tick_labels(each)
    }
    return [text for text in shown if id(text) not in ticks or id(text) in seen]


def all_labels(axis):
    ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
    return [label for tick in ticks for label in (tick.label1, tick.label2)]


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


def extent(text):
    return text.get_window_extent(text.figure.canvas.get_renderer())


def cut_texts(figure):
    edge = Bbox.from_bounds(0, 0, *(figure.get_size_inches() * DPI))
    for text in texts(figure):
        box = extent(text)
        if box.x0 < -1 or box.y0 < -1 or box.x1 > edge.x1 + 1 or box.y1 > edge.y1 + 1:
            yield f"{text.get_text()!r} is cut by the edge of the figure"


def overlapping_texts(figure):
    boxes = [(text.get_text(), extent(text)) for text in texts(figure)]
    for (one, first), (other, second) in combinations(boxes, 2):
        shared = Bbox.intersection(first, second)
        if shared is not None and min(shared.width, shared.height) > 1.5:
            yield f"{one!r} overlaps {other!r}"


def covered_data(figure):
    """Legends, and texts within axes, that lie on lines or points."""
    for legend in [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend())]:
        box = legend.get_window_extent(figure.canvas.get_renderer())
        yield from (f"a legend covers {name}" for name in data_in(figure, box))
    for axis in figure.axes:
        for text in axis.texts:
            if text in texts(figure) and not axis.images:
                box = extent(text).padded(-1)
                found = list(data_in(figure, box))
                if found:
                    yield f"{text.get_text()!r} lies on {found[0]}"


def data_in(figure, box):
    """Names of the lines and points that a box meets."""
    for axis in figure.axes:
        for line in axis.lines:
            if not line.get_visible():
                continue
            path = line.get_transform().transform_path(line.get_path())
            points = path.vertices[np.isfinite(path.vertices).all(axis=1)]
            has_line = line.get_linestyle() not in ("None", "none", "", " ")
            inside = Bbox.intersection(box, axis.bbox) if line.get_clip_on() else box
            if inside is None or not len(points):
                continue
            if (has_line and path.intersects_bbox(inside, filled=False)) or inside.count_contains(points):
                yield f"line {line.get_label()}"


def faint_texts(figure):
    """Texts whose contrast with the ground that they stand on is below 4.5."""
    hidden = texts(figure)
    for text in hidden:
        text.set_visible(False)
    sink = io.BytesIO()
    with matplotlib.rc_context(SETTINGS):
        engine, _ = figure.get_layout_engine(), figure.set_layout_engine("none")
        figure.savefig(sink, format="png", dpi=DPI)
        figure.set_layout_engine(engine)
    for text in hidden:
        text.set_visible(True)
    image = np.asarray(Image.open(sink).convert("RGB"))
    for text in hidden:
        box = extent(text)
        rows = slice(max(0, int(image.shape[0] - box.y1)), max(1, int(image.shape[0] - box.y0)))
        pixels = image[rows, max(0, int(box.x0)) : max(1, int(box.x1))].reshape(-1, 3)
        if len(pixels):
            colors, counts = np.unique(pixels, axis=0, return_counts=True)
            ground = colors[counts.argmax()] / 255.0
            if contrast(text.get_color(), ground) < 4.5:
                yield f"{text.get_text()!r} has a contrast of {contrast(text.get_color(), ground):.2f}"


def alike_series(figure):
    """Named series of one axes that differ neither in line nor in marker."""
    for axis in figure.axes:
        named = [line for line in axis.lines if not line.get_label().startswith("_")]
        looks = [look(line) for line in named]
        for one, other in combinations(range(len(named)), 2):
            if looks[one] == looks[other]:
                yield f"{named[one].get_label()} and {named[other].get_label()} look alike"


def look(line):
    """What tells a line from others without colour: dashes, marker, and whether it is filled."""
    is_open = line.get_markerfacecolor() in ("none", PAPER)
    return str(line._dash_pattern), line.get_linestyle(), line.get_marker(), is_open


def unnamed_axes(figure):
    """Axes of numbers without a label that has a unit."""
    shared = {"x": supports(figure, "_supxlabel"), "y": supports(figure, "_supylabel")}
    for axis in figure.axes:
        for each in (axis.xaxis, axis.yaxis):
            labels = [label.get_text() for label in tick_labels(each)]
            if not labels or not all(is_number(label) for label in labels):
                continue
            named = [each.get_label().get_text(), *shared[each.axis_name]]
            if not any("[" in name for name in named) and named[0] != "score":
                yield f"no unit on the {each.axis_name} axis of {axis.get_title(loc='left')!r}: {named}"


def supports(figure, name):
    found = [getattr(part, name) for part in (figure, *figure.subfigs) if getattr(part, name, None)]
    return [text.get_text() for text in found]


def is_number(label):
    try:
        float(label.replace("−", "-").replace(",", "").replace("$", ""))
    except ValueError:
        return "mathdefault" in label
    return True


def repeated_ticks(figure):
    """Axes of numbers with exponents, with too few ticks to read, or with the same label twice."""
    for axis in figure.axes:
        for each in (axis.xaxis, axis.yaxis):
            labels = [label.get_text() for label in tick_labels(each)]
            if any("mathdefault" in label or "e" in label for label in labels if is_number(label)):
                yield f"exponents on the {each.axis_name} axis: {labels}"
            if len(labels) == 1 and is_number(labels[0]):
                yield f"a single tick on the {each.axis_name} axis: {labels}"
            mirrored = labels == labels[::-1]
            if len(labels) != len(set(labels)) and not mirrored and all(map(is_number, labels)):
                yield f"the same tick label twice on the {each.axis_name} axis: {labels}"
