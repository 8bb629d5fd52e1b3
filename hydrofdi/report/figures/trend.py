"""A score over days: points, level with its interval, onset, limit and when it is reached."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hydrofdi.records import Array
from hydrofdi.report.figures.style import BLUE, GREY, ORANGE, SETTINGS, legend_above, shown

Interval = tuple[float, float, float]
"""Value, lower and upper end."""


@matplotlib.rc_context(SETTINGS)
def draw_trend(
    title: str,
    label: str,
    points: tuple[Array, Array, NDArray[np.bool_]],
    levels: tuple[Array, Array],
    onset: Interval | None,
    limit: float | None,
    reached: Interval | None,
    *,
    time_unit: str = "",
) -> Figure:
    """Draw a trend.

    Parameters
    ----------
    points : tuple of ndarray, shape (n,)
        Time, values, and whether each is used.
    levels : tuple of ndarray, shape (n_time,) and (3, n_time)
        Time; lower end, median and upper end of the level.
    onset, reached : Interval, optional
        Ends of `reached` may be infinite.
    time_unit : str
        Unit of all instants; days since 1970 if empty.
    """
    time, values, is_in = points
    instants, (low, level, high) = levels
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    axis: Any = figure.subplots()
    x = np.asarray if time_unit else _dates
    axis.plot(x(time[is_in]), values[is_in], "o", color=GREY, markersize=3, label="points")
    if not is_in.all():
        axis.plot(x(time[~is_in]), values[~is_in], "x", color=GREY, markersize=4, label="left out")
    axis.plot(x(instants), level, color=BLUE, linewidth=1.4, label="level")
    axis.fill_between(x(instants), low, high, color=BLUE, alpha=0.2, linewidth=0)
    edges = [instants[0], instants[-1]]
    if onset is not None:
        axis.axvspan(*x(onset[1:]), color=ORANGE, alpha=0.15, linewidth=0, label="onset")
        axis.axvline(x(onset[:1])[0], color=ORANGE, linestyle=":")
    if limit is not None:
        axis.axhline(limit, color=ORANGE, linestyle="--", linewidth=1.0, label="limit")
    if limit is not None and reached is not None and math.isfinite(reached[1]):
        ends = [max(reached[1], edges[0]), min(reached[2], edges[1])]
        axis.plot(x(ends), [limit, limit], color=ORANGE, linewidth=4.0, alpha=0.8, label="limit reached")
        if math.isfinite(reached[0]):
            axis.plot(x(reached[:1]), [limit], "D", color=ORANGE, markersize=5)
    if edges[1] > time[-1]:
        axis.axvline(x(time[-1:])[0], color=GREY, linewidth=0.6)
    _frame(axis, values[is_in], level, limit)
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    axis.set(ylabel=label, xlim=tuple(x(edges)))
    if time_unit:
        axis.set_xlabel(f"time [{time_unit}]")
    else:
        from matplotlib import dates

        places: Any = dates.AutoDateLocator()  # type: ignore[no-untyped-call]
        axis.xaxis.set_major_locator(places)
        axis.xaxis.set_major_formatter(dates.ConciseDateFormatter(places))  # type: ignore[no-untyped-call]
    legend_above(axis, 6)
    return shown(figure)


def _dates(days: Array | Sequence[float]) -> Any:
    return (np.asarray(days) * 86400.0).astype("datetime64[s]")


def _frame(axis: Any, values: Array, level: Array, limit: float | None) -> None:
    """Limits of the axis: what is known, and the limit; an interval beyond them is cut off."""
    known = [*values.tolist(), *level.tolist(), *([] if limit is None else [limit])]
    low, high = min(known), max(known)
    if limit is not None:
        far = max(abs(limit - float(np.median(values))), float(np.ptp(values)))
        high = min(high, max(limit, float(values.max())) + 0.5 * far)
        low = max(low, min(limit, float(values.min())) - 0.5 * far)
    room = 0.08 * (high - low or 1.0)
    axis.set_ylim(low - room, high + room)
