"""Dates: texts as instants, and instants as time since 1970."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from datetime import UTC, datetime, tzinfo
from typing import NamedTuple
from zoneinfo import ZoneInfo, available_timezones

import numpy as np

from hydrofdi.records.batch import Array
from hydrofdi.settings.messages import similar

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
        found = datetime.strptime(written, form) if form else datetime.fromisoformat(turned)
        found = found.replace(tzinfo=zone) if found.tzinfo is None else found
        passed = found - (_EPOCH if found.tzinfo is None else _EPOCH_UTC)
    except (ValueError, OverflowError):
        what = f"in the format {form!r}" if form else f"such as {_EXAMPLE}; state its format in 'time'"
        raise ValueError(f"{written[:40]!r} is not a date and time {what}") from None
    digits = _BEYOND.search(written)  # datetime ignores what is below a microsecond
    nanoseconds = int(f"{digits[1]:0<3}") if digits else 0
    whole = passed.days * 86_400 + passed.seconds
    return Instant(whole * _BILLION + passed.microseconds * 1000 + nanoseconds, found.tzinfo is not None)


def seconds_since(first: Instant | None, instants: Sequence[Instant | None]) -> Array:
    """Time since an instant [s], shape (n_time,); NaN for None. Rounded once, after the difference."""
    if any(found and first and found.has_zone != first.has_zone for found in instants):
        raise ValueError("some dates have a zone and others have none")
    start = first.nanoseconds if first else 0
    passed = (float("nan") if at is None else (at.nanoseconds - start) / _BILLION for at in instants)
    return np.fromiter(passed, np.float64, len(instants))


def unix_seconds(texts: Sequence[str], zone: tzinfo | None = None) -> Array:
    """Dates as time since 1970-01-01T00:00Z [s], shape (n_time,); `zone` is that of texts without one."""
    instants = [instant(text, zone) for text in texts]
    if not all(found.has_zone for found in instants):
        raise ValueError(
            f"the time has no zone; write it like {_EXAMPLE}, or state the zone in the file of"
            f" config: 'zone: Europe/Berlin'"
        )
    return np.array([found.nanoseconds / _BILLION for found in instants], dtype=np.float64)


_DAY = 86_400.0


def since_first(first: Instant | None, times: Array) -> tuple[Array, float]:
    """Times since a first instant [s], and this instant since 1970 [s]; times of day, which have no date,
    begin anew at midnight."""
    if first is not None and first.nanoseconds < _DAY * _BILLION:
        return times + _DAY * np.cumsum(np.diff(times, prepend=times[:1]) < -_DAY / 2.0), math.nan
    return times, math.nan if first is None else first.nanoseconds / _BILLION
