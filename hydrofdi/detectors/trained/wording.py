"""Formatting of scores and rates for readers."""

from __future__ import annotations

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.settings.readable import plain, readable_unit
from hydrofdi.units import convert


def score_name(file: DetectorFile) -> str:
    """Name of the score, such as ``dwt.d2``."""
    config = file.config
    return f"{config.indicator}.{config.output}" if config.output else config.indicator


def score_meaning(file: DetectorFile) -> str:
    """Description of the score, such as ``internal leakage flow of K_i at 8 MPa``."""
    return feature_of(file.config).described.long_name


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
