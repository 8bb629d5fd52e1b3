"""How figures look, and how they become files whose bytes depend on the data alone."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.figure import Figure

BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"
"""Colours that differ for the colour-blind and in grey (after Okabe and Ito)."""

INK, RULE, PAPER = "#1b1b1f", "#d9d9de", "#fefefe"
"""Text and axes, grid lines, and the ground; the page swaps these for its own in the dark."""

BLACK = "#101010"
"""Marks on coloured cells, which keep their colours in the dark."""

LINES = ("-", (0, (5, 1.5)), (0, (1, 1.2)))
"""Line styles that distinguish series without colour."""

SERIES = ((BLUE, LINES[0]), (ORANGE, LINES[1]), (GREEN, LINES[2]))
"""Colour and line style of the first, second, … EBM."""

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
    """Colour and line style of a series."""
    color, line = SERIES[position % len(SERIES)]
    return {"color": color, "linestyle": line}


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as png, svg or pdf; no clock, no random ids."""
    import matplotlib

    sink = io.BytesIO()
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(sink, format=kind, dpi=150, metadata=_METADATA[kind])
    return sink.getvalue()
