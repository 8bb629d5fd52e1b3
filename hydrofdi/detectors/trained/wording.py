"""Formatting of scores and rates for readers."""

from __future__ import annotations

import numpy as np

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.settings.readable import readable_unit
from hydrofdi.units import convert

_LEAST_PERCENT = 1e-4
"""Percentage below which digits are meaningless [%]."""

_LEAST_PLAIN, _MOST_PLAIN = 1e-9, 1e9
"""Range of magnitudes written without an exponent."""


def score_name(file: DetectorFile) -> str:
    """Name of the score, such as ``dwt.d2``."""
    config = file.config
    return f"{config.indicator}.{config.output}" if config.output else config.indicator


def score_meaning(file: DetectorFile) -> str:
    """Description of the score, such as ``internal leakage flow of K_i at 8 MPa``."""
    return feature_of(file.config).described.long_name


def percent(share: float) -> str:
    """A fraction as a percentage with three digits and the percent sign."""
    return f"{percentage(share)} %"


def percentage(share: float) -> str:
    """The same without the percent sign, e.g. for the lower end of a range."""
    value = 100.0 * share
    return f"below {_LEAST_PERCENT:.4f}" if 0.0 < value < _LEAST_PERCENT else f"{value:.3g}"


def plain(value: float, n_digit: int) -> str:
    """A number with `n_digit` significant digits; only extreme values have an exponent."""
    if not value or not _LEAST_PLAIN <= abs(value) < _MOST_PLAIN:
        return f"{value:.{n_digit}g}"
    return np.format_float_positional(value, n_digit, unique=False, fractional=False, trim="-")


def count_text(number: float) -> str:
    """A mean count, rounded for reading."""
    return f"{number:,.0f}" if number >= 9.95 else plain(number, 2)


def time_text(seconds: float) -> str:
    """A duration in seconds, minutes or hours."""
    size, unit = (3600.0, "h") if seconds >= 3600.0 else (60.0, "min") if seconds >= 60.0 else (1.0, "s")
    value = seconds / size
    return f"{value:,.0f} {unit}" if value >= 999.5 else f"{value:.3g} {unit}"


def score_unit(file: DetectorFile) -> str:
    """Unit for displaying scores, chosen to suit the limits."""
    ends = [abs(end) for end in (file.limits.low, file.limits.high) if end is not None]
    return readable_unit(file.unit, max(ends, default=0.0))


def limits_text(file: DetectorFile) -> str:
    """Description of the scores that raise an alarm, such as ``below 29 kPa or above 257 kPa``."""
    low, high = file.limits.low, file.limits.high
    texts = [] if low is None else [f"below {score_text(low, file)}"]
    texts += [] if high is None else [f"above {score_text(high, file)}"]
    return " or ".join(texts)


def score_text(score: float, file: DetectorFile) -> str:
    """A score in the display unit of its detector."""
    return _text(score, file.unit, score_unit(file))


def readable(value: float, unit: str) -> str:
    """An SI value with four digits, in a readable unit."""
    return _text(value, unit, readable_unit(unit, abs(value)))


def _text(value: float, unit: str, shown: str) -> str:
    number = plain(convert(value, shown) if shown != unit else value, 4)
    return number if shown == "1" else f"{number} {shown}"
