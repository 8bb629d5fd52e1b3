"""Nuisances of scores: their numbers as words, and as plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from hydrofdi.evaluation.populations import NOTHING, Kind
from hydrofdi.evaluation.sensitivity.estimate import Estimate
from hydrofdi.evaluation.sensitivity.response import EquivalentFault
from hydrofdi.report.detection.wording import SeverityUnit, severity_unit
from hydrofdi.report.forms.numbers import finite
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.judgement import Detection, Judgement
from hydrofdi.studies.nuisances import Nuisance, Nuisances, nuisances_of

RECORD_TO_RECORD, TOGETHER = "record to record", "all together"
"""Names of what differs between records of one actuator, and of all nuisances."""


@lru_cache(maxsize=1024)
def nuisances(detection: Detection, score: str) -> Nuisances | None:
    """The nuisances of a score by its name; None if the study has no records for them."""
    (scored,) = (each.scored for each in detection.judgements if each.scored.name == score)
    return nuisances_of(detection.records, scored, confidence=detection.rules.confidence)


def nuisance_name(nuisance: Nuisance) -> str:
    """A nuisance for people."""
    return RECORD_TO_RECORD if nuisance.parameter == NOTHING else nuisance.parameter


def by_share(found: Nuisances, most: int) -> list[Nuisance]:
    """The nuisances with the largest shares of the variance (else spreads alone), and record to record."""
    return _first(sorted(found.each, key=_share, reverse=True), most)


def by_reach(found: Nuisances, most: int) -> list[Nuisance]:
    """The nuisances that look like the largest faults, or hide them, and record to record."""
    stated = [each for each in found.each if each.reach is not None]
    return _first(sorted(stated, key=_reached, reverse=True), most)


def _first(ordered: list[Nuisance], most: int) -> list[Nuisance]:
    last = [each for each in ordered[most:] if each.parameter == NOTHING]
    return [*ordered[:most], *last]


def _share(nuisance: Nuisance) -> float:
    estimate = nuisance.total or nuisance.alone
    return estimate.value if estimate is not None else -math.inf


def _reached(nuisance: Nuisance) -> tuple[float, float]:
    assert nuisance.reach is not None
    ends = [end(fault) for fault in (nuisance.reach.imitated, nuisance.reach.hidden)]
    return max(ends), min(ends)


def end(fault: EquivalentFault) -> float:
    """The severity; 0 below the tested ones, infinite above."""
    return {"below": 0.0, "above": math.inf}.get(fault.place, fault.severity)


def percent_text(estimate: Estimate | None) -> str:
    """A share in percent with its interval, e.g. ``26 (-4 … 55)``."""
    if estimate is None:
        return HOLE
    value, low, high = (f"{100.0 * part:.0f}" for part in (estimate.value, estimate.low, estimate.high))
    return f"{value} ({low} … {high})".replace("-0 ", "0 ").replace(" ", "\N{NO-BREAK SPACE}")


@dataclass(frozen=True)
class TestedRange:
    """Smallest and largest nominal severity that is tested, and the unit to read them in."""

    smallest: float
    largest: float
    unit: SeverityUnit

    def text(self, fault: EquivalentFault | None) -> str:
        """A fault with its interval, e.g. ``0.17 (0.07–0.32)``, ``< 0.01``, ``0.7 (0.3–>1)``."""
        if fault is None:
            return HOLE
        value, low, high = (self._end(part) for part in (end(fault), fault.low, fault.high))
        return value if low == high else f"{value} ({low}–{high})".replace(" ", "\N{NO-BREAK SPACE}")

    def _end(self, severity: float) -> str:
        if severity == 0.0:
            return f"<{two_digits(self.unit.value(self.smallest))}"
        if math.isinf(severity):
            return f">{two_digits(self.unit.value(self.largest))}"
        return two_digits(self.unit.value(severity))


def tested_range(detection: Detection) -> TestedRange | None:
    """The severities that are tested; None without any."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if not levels:
        return None
    return TestedRange(levels[0].severity, levels[-1].severity, severity_unit(detection))


def nuisance_records(detection: Detection, judgement: Judgement) -> list[dict[str, Any]]:
    """The nuisances of a score as plain data; empty if the study has no records for them."""
    found, unit = nuisances(detection, judgement.scored.name), severity_unit(detection)
    if found is None:
        return []
    return [
        {
            "parameter": each.parameter,
            "alone": _estimate_record(each.alone),
            "first_order": _estimate_record(each.first_order),
            "total": _estimate_record(each.total),
            "imitates": None if each.reach is None else _fault_record(each.reach.imitated, unit),
            "hides": None if each.reach is None else _fault_record(each.reach.hidden, unit),
        }
        for each in found.each
    ]


def _estimate_record(estimate: Estimate | None) -> dict[str, Any] | None:
    if estimate is None:
        return None
    return {
        **{name: finite(getattr(estimate, name)) for name in ("value", "low", "high")},
        "n": estimate.n_record,
    }


def _fault_record(fault: EquivalentFault, unit: SeverityUnit) -> dict[str, Any]:
    """A fault, or the tested one that it lies below or above; an interval is open where its end is None."""
    ends = {name: finite(unit.value(getattr(fault, name))) for name in ("low", "high")}
    return {"place": fault.place, unit.key: unit.value(fault.severity), **ends}
