"""Conditions of windows: the oil temperature, and estimates of the machine; which of them records cover."""

from __future__ import annotations

import math
from collections.abc import Mapping

from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.errors import Issue
from hydrofdi.indicators import Output
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.readable import shown_quantity
from hydrofdi.units import ZEROS

Ranges = Mapping[str, tuple[float, float]]
"""Condition → lowest and highest value, in SI."""

TEMPERATURE = Channel.OIL_TEMPERATURE

_ESTIMATES = ("bulk_modulus", "supply_pressure")

_NARROW, _NARROW_SHARE = 10.0, 0.1
"""Span below which a range is narrow: of the temperature [K], of an estimate relative to its size."""

_MARGIN = 0.1
"""Margin of a covered range, as a share of its width and of a narrow width together; a choice."""

_FEW = 30
"""Number of windows below which margins are doubled, because few windows cover little of the range."""


def estimated_conditions(feature: Feature) -> dict[str, Output]:
    """Outputs that describe the condition of the machine and are not judged themselves."""
    numbers = [*feature.numbers]
    is_single = feature.score is None or feature.score.kind == "compensated"
    judged = numbers[:1] if is_single else numbers
    return {
        name: each
        for name, each in feature.outputs.items()
        if each.name in _ESTIMATES and not each.dims and name not in judged
    }


def conditions_of(feature: Feature, values: Mapping[str, Array], records: RecordBatch) -> dict[str, Array]:
    """Condition → its value in each window, shape (n_window,), in SI; NaN if there is none."""
    return temperatures(records) | {name: values[name] for name in estimated_conditions(feature)}


def temperatures(records: RecordBatch) -> dict[str, Array]:
    """Mean oil temperature of each window [K]; nothing if it is not measured."""
    return {TEMPERATURE: records[TEMPERATURE].mean(axis=1)} if TEMPERATURE in records.channels else {}


def widened(covered: Ranges, found: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Covered ranges that include the values of another window."""
    none = (math.inf, -math.inf)
    return dict(covered) | {
        name: (min(covered.get(name, none)[0], value), max(covered.get(name, none)[1], value))
        for name, value in found.items()
        if math.isfinite(value)
    }


def outside(covered: Ranges, n_window: int, found: Mapping[str, float]) -> Issue | None:
    """The first condition of a window that is outside of the range of the healthy windows and its margin."""
    for name, (low, high) in covered.items():
        value = found.get(name, math.nan)
        margin = _MARGIN * (1.0 + _FEW / n_window) * (high - low + _narrow(name, low, high))
        if value < low - margin or value > high + margin:
            text = f"{_said(name)} is {_shown(name, value)}"
            return Issue(f"{text}; healthy windows cover {_range(name, low, high)}", name, kind="novel")
    return None


def coverage(covered: Ranges) -> str:
    """A sentence about the conditions that healthy windows cover, and which are not covered."""
    known = [f"{_said(name)} {_range(name, *ends)}" for name, ends in covered.items()]
    narrow = [
        _said(name)
        for name, (low, high) in covered.items()
        if not name.endswith("supply_pressure") and high - low < _narrow(name, low, high)
    ]
    missing = [] if TEMPERATURE in covered else ["the oil temperature is not recorded"]
    if narrow:
        missing.append(f"{' and '.join(narrow)} hardly {'vary' if len(narrow) > 1 else 'varies'}")
    text = f"It covers {', '.join(known)}" if known else "The conditions that it covers are not known"
    if not missing:
        return f"{text}."
    is_warm_and_cold = TEMPERATURE in covered and _said(TEMPERATURE) not in narrow
    advice = "" if is_warm_and_cold else ", so record warm and cold"
    return f"{text}; {', '.join(missing)}: other conditions are not covered{advice}."


def _narrow(name: str, low: float, high: float) -> float:
    return _NARROW if name == TEMPERATURE else _NARROW_SHARE * abs(low + high) / 2.0


def _said(name: str) -> str:
    return name.replace("_", " ") if name == TEMPERATURE else name


def _range(name: str, low: float, high: float) -> str:
    return f"{_shown(name, low)} to {_shown(name, high)}"


def _shown(name: str, value: float) -> str:
    return f"{value - ZEROS['°C']:.1f} °C" if name == TEMPERATURE else shown_quantity(value, "Pa")
