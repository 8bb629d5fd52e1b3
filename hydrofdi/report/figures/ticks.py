"""Logarithmic axes with plain numbers."""

from __future__ import annotations

import math
from typing import Any

_LABEL = 0.45
"""Room for a label beside another [in]; above another, half of it."""


def plain_number(value: float) -> str:
    """A number without an exponent: ``0.001``, ``20``, ``1,000,000``."""
    import numpy as np

    if abs(value) >= 1e3:
        return f"{value:,.0f}"
    return np.format_float_positional(value, 3, fractional=False, trim="-")


def log_axis(axis: Any) -> None:
    """A logarithmic axis with as many plain numbers as fit: 0.1, 0.2, 0.5, 1, or decades if it is long.

    Parameters
    ----------
    axis : matplotlib.axis.Axis
        With its limits set, or its lines drawn.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    low, high = sorted(axis.get_view_interval())
    box = axis.axes.get_window_extent()
    length = (box.width if axis.axis_name == "x" else 2.0 * box.height) / axis.get_figure().dpi
    steps = (1.0, 2.0, 5.0) if 3.0 * math.log10(high / low) * _LABEL < length else (1.0,)
    axis.set_major_locator(LogLocator(subs=steps, numticks=20 if len(steps) > 1 else 9))
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain_number(value)))
    axis.set_minor_formatter(NullFormatter())
