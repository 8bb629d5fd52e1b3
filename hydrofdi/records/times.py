"""The column of time: dates, its unit, and how even the sampling is, of files and of streams."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from datetime import UTC, datetime, tzinfo
from typing import Any, NamedTuple
from zoneinfo import ZoneInfo, available_timezones

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import DataError, Issue
from hydrofdi.records import Array, columns
from hydrofdi.records.description import ChannelConfig, MeasuredConfig, TimeConfig, is_counts, known_unit
from hydrofdi.settings.messages import counted, similar
from hydrofdi.settings.quantities import ABOVE, BELOW
from hydrofdi.units import parse_unit, zero_of

FIRST_DATE, LAST_DATE = 1e9, 2.6e9
"""Least and largest instant of a clock that counts from 1970 [s]: the years 2001 to 2052."""
_POINTED = re.compile(r"^(\d{1,2})\.(\d{1,2})\.(\d{4})[T ]+(\d{1,2}):")
"""Day, month and year separated by dots, as in 31.01.2026 12:00."""
_BASIC = re.compile(r"\d{8}T\d{6}([.,]\d{1,9})?(Z|[-+]\d{2}(:?\d\d)?)?")
"""Date and time of ISO 8601 without signs between."""
_OF_DAY = re.compile(r"\d{1,2}:\d\d:\d\d([.,]\d{1,9})?")
_BEYOND = re.compile(r":\d\d[.,]\d{6}(\d{1,3})")
_EPOCH = datetime(1970, 1, 1)
_EPOCH_UTC = datetime(1970, 1, 1, tzinfo=UTC)
_BILLION = 10**9
_EXAMPLE = "2026-01-31T12:00:00.25Z"


class Instant(NamedTuple):
    """Time since 1970-01-01T00:00 [ns], in UTC if the zone is known."""

    nanoseconds: int
    has_zone: bool


def is_dated(text: str) -> bool:
    """Whether a text is meant as a date with a time of day, not as a number; the date may be invalid."""
    return ":" in text or bool(_BASIC.fullmatch(text.strip()))


def time_zone(name: str) -> tzinfo:
    """A time zone by its name, such as ``Europe/Berlin``, or its offset, such as ``+01:00``."""
    try:
        offset = datetime.fromisoformat(f"1970-01-01T00:00{name}").tzinfo if name[:1] in "+-" else None
        return offset or ZoneInfo(name)
    except (ValueError, OSError, KeyError):
        hint = similar(name, sorted(available_timezones())) or "; write it like Europe/Berlin, UTC or +01:00"
        raise ValueError(f"{name[:40]!r} is not a time zone{hint}") from None


def instant(text: str, zone: tzinfo | None = None, form: str = "") -> Instant:
    """The instant of a text in a stated format, else in ISO 8601, or such as 31.01.2026 12:00:00,25.

    It has `zone` if it states none; a time of day is on the first day.

    In an hour that repeats, the first pass is taken.
    """
    written = text.strip()
    try:
        turned = _POINTED.sub(lambda at: f"{at[3]}-{at[2]:0>2}-{at[1]:0>2}T{at[4]:0>2}:", written)
        turned = f"1970-01-01T{turned:0>8}" if _OF_DAY.fullmatch(turned) else turned
        date = datetime.strptime(written, form) if form else datetime.fromisoformat(turned)
        date = date.replace(tzinfo=zone) if date.tzinfo is None else date
        passed = date - (_EPOCH if date.tzinfo is None else _EPOCH_UTC)
    except (ValueError, OverflowError):
        what = f"in the format {form!r}" if form else f"such as {_EXAMPLE}; state its format in 'time'"
        raise ValueError(f"{written[:40]!r} is not a date and time {what}") from None
    digits = _BEYOND.search(written)  # datetime ignores what is below a microsecond
    nanoseconds = int(f"{digits[1]:0<3}") if digits else 0
    whole = passed.days * 86_400 + passed.seconds
    return Instant(whole * _BILLION + passed.microseconds * 1000 + nanoseconds, date.tzinfo is not None)


def seconds_since(first: Instant | None, instants: Sequence[Instant | None]) -> Array:
    """Time since an instant [s], shape (n_time,); NaN for None. Rounded once, after the difference."""
    if any(date and first and date.has_zone != first.has_zone for date in instants):
        raise ValueError("some dates have a zone and others have none")
    start = first.nanoseconds if first else 0
    passed = (float("nan") if at is None else (at.nanoseconds - start) / _BILLION for at in instants)
    return np.fromiter(passed, np.float64, len(instants))


def unix_seconds(texts: Sequence[str], zone: tzinfo | None = None) -> Array:
    """Dates as time since 1970-01-01T00:00Z [s], shape (n_time,); `zone` is that of texts without one."""
    instants = [instant(text, zone) for text in texts]
    if not all(date.has_zone for date in instants):
        raise ValueError(
            f"the time has no zone; write it like {_EXAMPLE}, or state the zone in the file of"
            f" config: 'zone: Europe/Berlin'"
        )
    return np.array([date.nanoseconds / _BILLION for date in instants], dtype=np.float64)


_DAY = 86_400.0


def since_first(first: Instant | None, times: Array) -> tuple[Array, float]:
    """Times since a first instant [s], and this instant since 1970 [s]; times of day, which have no date,
    begin anew at midnight."""
    if first is not None and first.nanoseconds < _DAY * _BILLION:
        return times + _DAY * np.cumsum(np.diff(times, prepend=times[:1]) < -_DAY / 2.0), math.nan
    return times, math.nan if first is None else first.nanoseconds / _BILLION


def are_times(values: NDArray[Any]) -> bool:
    """Whether an array contains dates, texts of dates, or durations."""
    is_text = values.dtype.kind in "OU" and values.size
    return values.dtype.kind in "mM" or bool(is_text and is_dated(str(values.flat[0])))


def instants_of(values: NDArray[Any]) -> tuple[Array, float]:
    """Durations [s], or the time since the first of dates [s], and this one since 1970 [s], else NaN."""
    second = np.timedelta64(1, "s")
    if values.dtype.kind == "m":
        return values / second, math.nan
    if values.dtype.kind != "M":
        dates = [instant(str(value)) for value in values.tolist()]
        return since_first(dates[0], seconds_since(dates[0], dates))
    known = values[~np.isnat(values)]
    if not known.size:
        return np.full(values.shape, np.nan), math.nan
    return (values - known[0]) / second, float((known[0] - np.datetime64(0, "s")) / second)


_COUNTER = (
    "counts the samples and is not a time; give the sampling frequency instead, such as"
    " 'sampling_frequency: 1 kHz'"
)
_SECOND = parse_unit("s")
_TIMES = ("time", "t", "timestamps")
"""Names of time columns, the preferred one first."""
_DATES = {"timestamp", "datetime", "zeit", "zeitstempel", *_TIMES}
"""Names of time columns that contain dates."""


def time_column(table: columns.Titled, configured: TimeConfig | None) -> columns.ReadColumn | None:
    """The column of time, as configured, or else by its name; None if there is none.

    Dates need no unit, and ``time`` is in seconds if none is stated.
    """
    if configured is not None:
        positions = [table.find(configured.column)]
    elif clocks := table.clocks():
        positions = [next(iter(clocks.values()))]
    elif len(positions := named_time(table)) > 1:
        names = ", ".join(columns.shortened(table.titles[n]) for n in positions)
        raise DataError(f"{table.place}: has more than one column of time: {names}")
    if not positions:
        return None
    position, title = positions[0], table.titles[positions[0]]
    config = ChannelConfig(column=title, unit=configured.unit if configured else "")
    are_dates, header = table.is_dated(position), table.unit(position)
    header = "" if are_dates and not known_unit(header) else header
    if are_dates and not (header or config.unit or columns.unit_by_name(title)):
        return columns.ReadColumn(position, title, config, "", None)
    column = columns.column_at(table, position, config, "s", header)
    if is_counts(column.unit):
        raise DataError(f"{table.place}: column {title[:60]!r}: {_COUNTER}")
    return column


def named_time(table: columns.Titled) -> list[int]:
    """Columns with a name of time: numbers with a unit are preferred to dates."""
    titles = table.titles
    dated = [n for n, title in enumerate(titles) if columns.short_name(title) in _DATES and table.is_dated(n)]
    named = titles_of_time(table)
    usable = [n for n in named if n in dated or table.unit(n) or columns.unit_by_name(titles[n])]
    return usable or dated or named


def titles_of_time(table: columns.Titled) -> list[int]:
    """Positions of the preferred name of time among titles, unless their unit has another dimension."""
    named: dict[str, list[int]] = {name: [] for name in _TIMES}
    for position, name in enumerate(map(columns.short_name, table.titles)):
        unit = known_unit(table.unit(position)) if name in named else None
        if name in named and (unit is None or unit.exponents == _SECOND.exponents):
            named[name].append(position)
    return next((positions for positions in named.values() if positions), [])


def counts_samples(values: Array) -> bool:
    """Whether a column rises by one from sample to sample: a counter, if it has no unit."""
    return values.size > 1 and bool(np.all(np.diff(values) == 1.0))


_USUAL_RATES, _FAST = (20.0, 1e6), 20e3
"""Rates [Hz] at which a time without a unit is believed to be in seconds; above the last one, unless another
unit gives a round rate below it."""
_ROUND = (1.0, 2.0, 2.5, 4.0, 5.0, 10.0)
"""What round rates begin with."""
_LIKELY_UNITS = ("s", "ms", "µs", "ns", "min", "h", "day", "FILETIME", "exceldays")
_FEWEST = 10


def likely_unit(values: Array) -> str:
    """The unit in which a column of time is a date, or else has a usual rate; seconds if its rate cannot be
    seen; empty if no unit is likely, or more than one."""
    known = values[np.isfinite(values)]
    steps = np.diff(known)
    if known.size < _FEWEST or not (step := float(np.median(steps))) > 0.0:
        return "s"
    mean, likely, rounded = float(known[-1] - known[0]) / steps.size, list[str](), list[str]()
    for unit in _LIKELY_UNITS:
        factor, zero = float(parse_unit(unit).factor), zero_of(unit)
        rate = 1.0 / (factor * step)
        if not BELOW * _USUAL_RATES[0] <= rate <= ABOVE * _USUAL_RATES[1]:
            continue
        if FIRST_DATE <= factor * known[0] + zero <= LAST_DATE:
            return unit
        if not zero and (rate <= ABOVE * _FAST or unit == "s"):
            likely.append(unit)
            first = [float(f"{1.0 / (factor * period):.3e}"[:5]) for period in (step, mean)]
            rounded += [unit] * any(abs(period / usual - 1.0) < 2e-3 for period in first for usual in _ROUND)
    if likely[:1] == ["s"]:
        others = [unit for unit in rounded if unit != "s"]
        return others[0] if 1.0 / step > ABOVE * _FAST and others else "s"
    candidates = likely if len(likely) == 1 else rounded
    return candidates[0] if len(candidates) == 1 else ""


def require_seconds(values: Array, where: str) -> None:
    """Refuse a time without a unit that counts samples, or is no time in seconds."""
    if counts_samples(values):
        raise DataError(f"{where}: {_COUNTER}")
    if (unit := likely_unit(values)) != "s":
        rate = 1.0 / float(np.median(np.diff(values)))
        hint = f"is it in {unit} ({rate / float(parse_unit(unit).factor):.4g} Hz)? " if unit else ""
        raise DataError(
            f"{where}: has no unit, and {rate:.4g} Hz if it is in seconds; {hint}State the unit, as in"
            f" 'time [{unit or 's'}]' or 'time: {{column: …, unit: {unit or 's'}}}'; s, if that is right"
        )


_TOLERANCE = 0.01
"""Share by which a stated sampling frequency may differ from a column of time."""


def contradicting_times(table: columns.FileColumns, frequency: float) -> tuple[Issue, ...]:
    """A remark if median and mean step of a time column contradict the stated sampling frequency."""
    for position in (n for n in titles_of_time(table) if known_unit(table.unit(n))):
        title = table.titles[position]
        try:
            values = table.numbers(position)
        except DataError:
            continue
        times = columns.scaled(values, columns.factor_to_si(table.unit(position), "s", title))
        steps = np.diff(times[np.isfinite(times)])
        expected = np.array([np.median(steps), np.mean(steps)]) * frequency if steps.size else np.ones(2)
        if np.all(np.abs(expected - 1.0) > _TOLERANCE):
            with np.errstate(divide="ignore"):
                rate = frequency / expected[0]
            text = f"column {title!r} says {rate:g} Hz, the description {frequency:g} Hz"
            return (Issue(text, kind="sampling_differs"),)
    return ()


_GAP = 1.751
"""Longest step between samples without a gap, in median steps: 7/4 even if it is rounded."""
_MOSTLY = 2.0
"""Duration of a record over that of its samples from which on it is mostly gaps."""
_DIGITS = 9
_JOINED = 0.1
"""Share by which the median step differs from the mean if stamps of other rasters lie between."""


def sampling_of_times(
    times: Array, config: MeasuredConfig, table: columns.FileColumns
) -> tuple[float, list[Issue]]:
    """The sampling frequency of the instants of a table [Hz], and remarks on gaps and uneven steps."""
    steps = np.diff(times)
    if n_missing := np.count_nonzero(~np.isfinite(times)):
        text = f"{n_missing} sampling instants are missing; give 'sampling_frequency' in place of 'time'"
        raise columns.RejectionError("time", text)
    rounded = _rounded(times)
    if (bad := np.flatnonzero(steps <= 0.0)).size:
        relation = "the same as" if steps[bad[0]] == 0.0 else "before"
        text = f"{table.row_place(int(bad[0]) + 1)}: the time is {relation} that of the row above"
        raise columns.RejectionError("time", f"{text}; {_remedy(steps, rounded)}")
    typical = float(np.median(steps))
    mean = float(times[-1] - times[0]) / (times.size - 1)
    is_joined = bool(np.isfinite(mean)) and abs(typical / mean - 1.0) > _JOINED
    step = typical if np.any(steps > _GAP * typical) or is_joined else mean
    frequency = float(f"{1.0 / step:.{_DIGITS}g}")
    if not 0.0 < frequency < np.inf:
        raise columns.RejectionError("time", f"time goes from {times[0]:g} s to {times[-1]:g} s")
    uneven = _unevenness(times, steps, typical, frequency, config)
    if uneven and rounded:
        text = f"stamps are rounded to {rounded[1]:.2g} s, and even at {rounded[0]:g} Hz within that"
        return rounded[0], [Issue(text, kind="rounded")]
    return frequency, uneven


def _remedy(steps: Array, rounded: tuple[float, float] | None) -> str:
    """What to do about instants that do not increase."""
    typical = float(np.median(steps))
    if rounded:
        return f"stamps are rounded to {rounded[1]:.2g} s: state 'sampling_frequency: {rounded[0]:g} Hz'"
    if not np.any(steps < 0.0):
        return "stamps are coarser than the samples, or repeat: state 'sampling_frequency', or remove rows"
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
