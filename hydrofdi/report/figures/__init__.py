"""Figures, drawn with matplotlib and no global state: their style, axes, and files without a clock."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from hydrofdi.errors import HydrofdiError, ReportError, StoreError
from hydrofdi.settings.messages import similar
from hydrofdi.store.files import whole_file

if TYPE_CHECKING:
    from hydrofdi.report.document import ComposedReport

KINDS = ("png", "svg", "pdf")
"""File types of figures."""

BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"
PINK, GOLD, VIOLET, SKY, GREY = "#c2528b", "#9b6a00", "#7b61c9", "#1f8fc4", "#6e6e76"
"""Colours with a contrast of at least 3 on the light and on the dark ground (after Okabe and Ito)."""

COLORS = (BLUE, ORANGE, GREEN, PINK, GOLD, VIOLET, GREY, SKY)
"""Colours of the first, second, … series."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p")
"""Markers of the first, second, … series, so that they differ without colour."""

INK, RULE, PAPER = "#1b1b1f", "#d9d9de", "#fefefe"
"""Colours of text and axes, grid lines, and background; the page replaces them in dark mode."""

_DASHES = ((5, 1.5), (1, 1.2), (6, 1.5, 1, 1.5), (10, 2), (5, 1, 1, 1, 1, 1), (3, 3), (1, 3))

LINES = ("-", *((0, dashes) for dashes in _DASHES))
"""Line styles of the first, second, … series, so that they differ without colour."""

SETTINGS: Any = {
    "svg.hashsalt": "hydrofdi", "svg.fonttype": "path", "path.simplify_threshold": 0.3,
    "font.size": 9.0, "axes.titlesize": 9.5, "axes.titlelocation": "left", "axes.labelsize": 9.0,
    "legend.fontsize": 8.0, "legend.frameon": False, "lines.linewidth": 0.9,
    "axes.grid": True, "axes.axisbelow": True, "grid.color": RULE, "grid.linewidth": 0.5,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": INK, "xtick.color": INK, "ytick.color": INK,
    "axes.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False,
    "figure.facecolor": PAPER, "axes.facecolor": PAPER, "savefig.facecolor": PAPER,
}  # fmt: skip
"""Settings of matplotlib while a figure is drawn and saved."""

_METADATA: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}


def series(position: int) -> dict[str, Any]:
    """Colour and line style of a series; beyond eight, each colour has another style."""
    turn, color = divmod(position, len(COLORS))
    return {"color": COLORS[color], "linestyle": LINES[(color + turn) % len(LINES)]}


def shown(figure: Figure) -> Figure:
    """The figure, as a picture in notebooks: IPython shows figures without pyplot by this method alone."""
    figure.__dict__["_repr_png_"] = partial(figure_bytes, figure, "png")
    return figure


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as png, svg or pdf; no clock, no random ids."""
    sink = io.BytesIO()
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(sink, format=kind, dpi=150, metadata=_METADATA[kind])
    return sink.getvalue()


def time_axis(axis: Any, time: Any, most: int = 10) -> None:
    """An axis of time [s] with round numbers."""
    axis.xaxis.set_major_locator(MaxNLocator(most, steps=[1, 2, 5, 10]))
    axis.set(xlabel="time [s]", xlim=(time[0], time[-1]))


def legend_above(axis: Any, n_column: int = 1) -> None:
    """A legend above the panel, where it hides no line."""
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=n_column, borderaxespad=0.2)


_LABEL = 0.45
"""Room for a label beside another [in]; above another, half of it."""


def plain_number(value: float) -> str:
    """A number without an exponent: ``0.001``, ``20``, ``1,000,000``."""
    if abs(value) >= 1e3:
        return f"{value:,.0f}"
    return np.format_float_positional(value, 3, fractional=False, trim="-")


def log_axis(axis: Any) -> None:
    """A logarithmic axis with as many plain numbers as fit: 0.1, 0.2, 0.5, 1, or decades if it is long."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    low, high = sorted(axis.get_view_interval())
    box = axis.axes.get_window_extent()
    length = (box.width if axis.axis_name == "x" else 2.0 * box.height) / axis.get_figure().dpi
    steps = (1.0, 2.0, 5.0) if 3.0 * math.log10(high / low) * _LABEL < length else (1.0,)
    axis.set_major_locator(LogLocator(subs=steps, numticks=20 if len(steps) > 1 else 9))
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain_number(value)))
    axis.set_minor_formatter(NullFormatter())


_TICKS = (0.001, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 0.999)


def logit_axis(axis: Any, least: float) -> None:
    """Show percent on an axis of log-odds, from `least` to 1 - `least`."""
    ticks = [tick for tick in _TICKS if least <= tick <= 1.0 - least]
    axis.axes.set(**{f"{axis.axis_name}scale": "logit", f"{axis.axis_name}lim": (least, 1.0 - least)})
    axis.set_ticks(ticks, [f"{100.0 * tick:g}" for tick in ticks])
    axis.set_minor_locator(NullLocator())


def percent_axis(axes: Any, highest: float) -> None:
    """A horizontal axis of percent, logarithmic above 1 %, so that small rates can be read."""
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.5)
    axes.set_xlim(0.0, min(1.15 * highest, 100.0))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.minorticks_off()


def panels(
    count: int, columns: int, *, width: float, height: float, x: str = "", y: str = "", **shared: Any
) -> tuple[Any, list[Any]]:
    """A figure with `count` panels in rows, and the panels; `x` and `y` are labels of all of them."""
    columns = min(count, columns)
    rows = -(-count // columns)
    figure = Figure(figsize=(max(width * columns, 9.0), height * rows + 0.4), layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False, **shared).flat)
    for axis in axes[:count]:
        axis.tick_params(labelsize=7.5)
    for axis in axes[count:]:
        axis.remove()
    if x:
        figure.supxlabel(x, fontsize=9)
    if y:
        figure.supylabel(y, fontsize=9)
    return figure, axes[:count]


def legend_outside(figure: Any, styles: Mapping[str, Mapping[str, Any]], ncols: int, title: str = "") -> None:
    """A legend above all panels: label → style of a line."""
    handles = [Line2D([], [], label=label, **style) for label, style in styles.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=ncols, title=title or None)


def row_axis(axis: Any, labels: Sequence[str], fontsize: float = 8) -> None:
    """Rows with their names, the first one on top."""
    axis.set_yticks(range(len(labels)), labels, fontsize=fontsize)
    axis.set_ylim(len(labels) - 0.4, -0.6)


def draw_figure(report: ComposedReport, name: str | None) -> Figure:
    """A figure of a report by its name, or the usual one."""
    figures = report.figures()
    if not figures:
        raise ReportError(
            "there is nothing to draw: no run has results; 'hydrofdi sweep CONFIG' computes the missing runs"
        )
    if (name := name or next(iter(figures))) not in figures:
        raise ReportError(f"no figure {name!r}; there are {', '.join(figures)}{similar(name, [*figures])}")
    with matplotlib.rc_context(SETTINGS):
        return shown(figures[name].draw())


def draw_all(report: ComposedReport, names: Sequence[str]) -> tuple[dict[str, Figure], dict[str, str]]:
    """The figures of these names that the experiment allows, and the reasons why others are missing."""
    drawn: dict[str, Figure] = {}
    holes: dict[str, str] = {}
    for name in names:
        try:
            drawn[name] = draw_figure(report, name)
        except HydrofdiError as error:
            holes[name] = str(error)
    return drawn, holes


def write_figure(report: ComposedReport, path: Path) -> str:
    """Draw the figure that a file is named after; returns its caption."""
    save_figure(draw_figure(report, path.stem), path)
    return report.figures()[path.stem].caption


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; its kind follows from the suffix (.png, .svg, .pdf)."""
    kind = path.suffix.lstrip(".").lower()
    if kind not in KINDS:
        raise StoreError(f"{path}: figures are written as .png, .svg or .pdf")
    content = figure_bytes(figure, kind)
    with whole_file(path) as aside:
        aside.write_bytes(content)
