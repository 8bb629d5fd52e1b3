"""The sampling of instants: rate, gaps, rounding and evenness, of files and of streams."""

from __future__ import annotations

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.columns import RejectionError, Table
from hydrofdi.records.description import MeasuredConfig
from hydrofdi.settings.messages import counted
from hydrofdi.units import parse_unit

_GAP = 1.751
"""Longest step between samples without a gap, in median steps: 7/4 even if it is rounded."""
_MOSTLY = 2.0
"""Duration of a record over that of its samples from which on it is mostly gaps."""
_DIGITS = 9
_JOINED = 0.1
"""Share by which the median step differs from the mean if stamps of other rasters lie between."""
_FEWEST = 10


def sampling_of_times(times: Array, config: MeasuredConfig, table: Table) -> tuple[float, list[Issue]]:
    """The sampling frequency of the instants of a table [Hz], and remarks on gaps and uneven steps."""
    steps = np.diff(times)
    if n_missing := np.count_nonzero(~np.isfinite(times)):
        text = f"{n_missing} sampling instants are missing; give 'sampling_frequency' in place of 'time'"
        raise RejectionError("time", text)
    rounded = _rounded(times)
    if (bad := np.flatnonzero(steps <= 0.0)).size:
        relation = "the same as" if steps[bad[0]] == 0.0 else "before"
        text = f"{table.row_place(int(bad[0]) + 1)}: the time is {relation} that of the row above"
        raise RejectionError("time", f"{text}; {_remedy(steps, rounded)}")
    typical = float(np.median(steps))
    mean = float(times[-1] - times[0]) / (times.size - 1)
    is_joined = bool(np.isfinite(mean)) and abs(typical / mean - 1.0) > _JOINED
    step = typical if np.any(steps > _GAP * typical) or is_joined else mean
    frequency = float(f"{1.0 / step:.{_DIGITS}g}")
    if not 0.0 < frequency < np.inf:
        raise RejectionError("time", f"time goes from {times[0]:g} s to {times[-1]:g} s")
    uneven = _unevenness(times, steps, typical, frequency, config)
    if uneven and rounded:
        text = f"stamps are rounded to {rounded[1]:.2g} s, and even at {rounded[0]:g} Hz within that"
        return rounded[0], [Issue(text, kind="rounded")]
    return frequency, uneven


def _remedy(steps: Array, rounded: tuple[float, float] | None) -> str:
    """What to do about instants that do not increase."""
    typical, n_back = float(np.median(steps)), int(np.count_nonzero(steps < 0.0))
    if rounded:
        return f"stamps are rounded to {rounded[1]:.2g} s: state 'sampling_frequency: {rounded[0]:g} Hz'"
    if n_back > steps.size / 2:
        return "sort the rows by time"
    if not n_back:
        return (
            "stamps are coarser than the samples, or rows repeat: state 'sampling_frequency', or remove rows"
        )
    if typical > 0.0 and np.all(np.abs(steps[steps > 0.0] / typical - 1.0) < _JOINED):
        rate = float(f"{1.0 / typical:.4g}")
        return f"if a counter or a clock began anew there, state 'sampling_frequency: {rate:g} Hz'"
    return "sort the rows by time, or state 'sampling_frequency' if a clock was set back"


def _rounded(times: Array) -> tuple[float, float] | None:
    """Rate of an even clock [Hz] whose stamps were rounded, to decimals or to single precision, and to what
    [s]; None if rounding does not explain the instants."""
    some = np.concatenate([times[:1000], times[1000:][-1000:]])
    size = float(np.max(np.abs(some)))
    grids = [10.0**-n for n in range(10) if np.all(np.abs(some * 10.0**n - np.rint(some * 10.0**n)) < 0.01)]
    for unit in (1.0, 1e-3, 1e-6):
        single = (some / unit).astype(np.float32)
        is_near = np.abs(single - some / unit) < 0.05 * np.spacing(np.abs(single)).astype(np.float64)
        if np.all(is_near) and np.unique(single).size > some.size / 2:
            grids.append(unit * float(np.spacing(np.float32(size / unit))))
    number = np.arange(times.size) - (times.size - 1) / 2.0
    slope = float(number @ times / (number @ number))
    grid, width = max(grids, default=0.0), float(np.ptp(times - slope * number))
    if times.size < _FEWEST or not 0.0 < width <= _WIDTH * grid:
        return None
    # an even clock on a grid takes two neighbouring steps, the rarer one at even distances (three-distance
    # theorem; one more where halves are rounded to even); lost samples lie anywhere
    counts = np.rint(np.diff(times) / grid)
    rare = np.flatnonzero(counts != np.median(counts))
    if counts.all() and (rare.size < _FEWEST_RARE or np.ptp(counts) > 1.0 or np.ptp(np.diff(rare)) > 2.0):
        return None
    # the shortest number that the stamps cannot tell from the slope
    rates = (float(f"{1.0 / slope:.{digits}g}") for digits in range(1, 17))
    tolerance = 0.1 * grid / (slope * times.size)
    return next(rate for rate in rates if abs(rate * slope - 1.0) <= max(tolerance, 1e-15)), grid


_FEWEST_RARE = 3
_WIDTH = 1.1
"""Width of the instants around an even clock, in units of their last digit; rounding alone makes 1."""


def _unevenness(
    times: Array, steps: Array, typical: float, frequency: float, config: MeasuredConfig
) -> list[Issue]:
    gaps = int(np.count_nonzero(steps > _GAP * typical))
    asked = (
        f"; state 'resample: {float(f'{frequency:.3g}'):g} Hz' to interpolate"
        if config.resample is None
        else f"; interpolated at {config.resample:g} Hz"
    )
    if gaps:
        longest = float(steps.max())
        text = f"{counted(gaps, 'gap')} in time, the longest {longest:.3g} s{asked}"
        # windows that touch no gap are judged, unless most of the record is missing
        is_short = times[-1] - times[0] < _MOSTLY * typical * times.size
        return [Issue(text, kind="gap" if is_short else "gaps", is_unusable=config.resample is None)]
    deviation = _deviation(times) / typical
    if deviation <= config.limits.uneven + 1e-4:
        return []
    text = f"sampling is uneven: up to {deviation:.0%} of a step from even{asked}"
    return [Issue(text, kind="uneven", is_unusable=config.resample is None)]


def _deviation(times: Array) -> float:
    """Largest distance of instants from even ones between the first and the last [s]."""
    even = np.linspace(times[0], times[-1], times.size)
    even -= times
    return float(max(even.max(), -even.min()))


_OF_STREAMS = 0.25
"""Distance from even sampling as a share of a step that a stream may have: its stamps jitter."""
_OTHER_UNITS = ("ms", "µs", "ns", "FILETIME", "min", "h", "exceldays")


def uneven_window(times: Array) -> str:
    """What is uneven in the instants of a window; empty if nothing is."""
    share = _deviation(times) * (times.size - 1) / float(times[-1] - times[0]) if times.size > 2 else 0.0
    if share <= _OF_STREAMS or _rounded(times):
        return ""
    return f"stamps are uneven: up to {share:.0%} of a step from even; a stream may have {_OF_STREAMS:.0%}"


def other_unit(step: float, period: float) -> str:
    """A question if a step in another unit of time would be that of the sampling frequency; else empty."""
    units = (
        unit for unit in _OTHER_UNITS if abs(step * float(parse_unit(unit).factor) / period - 1.0) < 0.05
    )
    unit = next(units, "")
    return f"; is the time in {unit}? State its unit" if unit else ""
