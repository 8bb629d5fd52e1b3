"""Axes of rates: normal deviates, roots."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrofdi.evaluation.scores import Array

_TICKS = (0.001, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 0.999)

_PERCENT = (0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 25.0, 50.0, 75.0, 100.0)


def deviates(rates: Array, least: float) -> Array:
    """Φ⁻¹ of rates, those of 0 and 1 drawn at the ends of the axis."""
    from scipy.special import ndtri

    return np.asarray(ndtri(np.clip(rates, least, 1.0 - least)))


def normal_deviate_axis(axis: Any, least: float) -> None:
    """Show percent on an axis of normal deviates, from `least` to 1 - `least`.

    Parameters
    ----------
    axis : matplotlib.axis.Axis
    least : float
        Smallest rate.
    """
    ticks = np.array([tick for tick in _TICKS if least <= tick <= 1.0 - least])
    axis.set_ticks(deviates(ticks, least), [f"{100.0 * tick:g}" for tick in ticks])
    low, high = deviates(np.array([least, 1.0 - least]), least)
    axis.axes.set(**{f"{axis.axis_name}lim": (low - 0.08, high + 0.08)})


def root_percent_axis(axes: Any, highest: float) -> None:
    """A horizontal axis of percent, whose scale is the square root, so that small rates can be read.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    highest : float
        Largest value that is drawn [%].
    """
    end = min(1.15 * highest, 100.0)
    ticks = [0.0]
    for tick in _PERCENT:
        if tick <= end and np.sqrt(tick) - np.sqrt(ticks[-1]) > 0.1 * np.sqrt(end):
            ticks.append(tick)
    axes.set_xscale("function", functions=(lambda x: np.sqrt(np.maximum(x, 0.0)), np.square))
    axes.set_xlim(0.0, end)
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
