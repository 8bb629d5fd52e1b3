"""What moves healthy scores, and so causes false alarms and missed leaks: sentences, tables, plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from hydrofdi.evaluation.populations import NOTHING, Kind
from hydrofdi.evaluation.sensitivity.estimate import Estimate
from hydrofdi.evaluation.sensitivity.response import EquivalentFault, Reach
from hydrofdi.report.detection.selection import best_with_sensors, distinct, wavelet_rules
from hydrofdi.report.detection.wording import SeverityUnit, severity_unit
from hydrofdi.report.document import Block
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.table import Column, Table
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.judgement import Detection
from hydrofdi.studies.nuisances import Nuisance, Nuisances, nuisances_of

TOGETHER = "all together"
MOST, MOST_ROWS = 8, 6
"""Scores that are shown, and nuisances of each."""

_GAP = "\N{NO-BREAK SPACE}"


@lru_cache(maxsize=1024)
def nuisances(detection: Detection, score: str) -> Nuisances | None:
    """The nuisances of a score by its name; None if the study has no records for them."""
    (scored,) = (each.scored for each in detection.judgements if each.scored.name == score)
    return nuisances_of(detection.records, scored, confidence=detection.rules.confidence)


def shown_nuisances(detection: Detection) -> list[tuple[str, Nuisances]]:
    """The nuisances of the best score with each set of sensors and of the wavelet rules."""
    best = best_with_sensors(detection).values()
    chosen = distinct(*best, *wavelet_rules(detection), *detection.judgements[:1])
    names = [each.scored.name for each in chosen][:MOST]
    return [(name, found) for name in names if (found := nuisances(detection, name)) is not None]


def nuisance_name(nuisance: Nuisance) -> str:
    """A nuisance for people."""
    return "record to record" if nuisance.parameter == NOTHING else nuisance.parameter


def by_reach(found: Nuisances, most: int) -> list[tuple[str, Reach]]:
    """All together, then the nuisances that look like or hide the largest faults, and record to record."""
    stated = [each for each in found.each if each.reach is not None]
    first = _first(sorted(stated, key=_reached, reverse=True), most)
    named = [(TOGETHER, found.together), *((nuisance_name(each), each.reach) for each in first)]
    return [(name, reach) for name, reach in named if reach is not None]


def _by_share(found: Nuisances, most: int) -> list[Nuisance]:
    """The nuisances with the largest shares of the variance (else spreads alone), and record to record."""

    def share(nuisance: Nuisance) -> float:
        estimate = nuisance.total or nuisance.alone
        return estimate.value if estimate is not None else -math.inf

    return _first(sorted(found.each, key=share, reverse=True), most)


def _first(ordered: list[Nuisance], most: int) -> list[Nuisance]:
    return [*ordered[:most], *(each for each in ordered[most:] if each.parameter == NOTHING)]


def _reached(nuisance: Nuisance) -> tuple[float, float]:
    assert nuisance.reach is not None
    ends = [end(fault) for fault in (nuisance.reach.imitated, nuisance.reach.hidden)]
    return max(ends), min(ends)


def end(fault: EquivalentFault) -> float:
    """The severity; 0 below the tested ones, infinite above."""
    return {"below": 0.0, "above": math.inf}.get(fault.place, fault.severity)


def tested_range(detection: Detection) -> tuple[float, float] | None:
    """The smallest and the largest nominal severity that is tested; None without any."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    return (levels[0].severity, levels[-1].severity) if levels else None


def why_block(detection: Detection) -> Block | None:
    """Which nuisance moves which score; None if the study has no records for it."""
    shown, tested, unit = shown_nuisances(detection), tested_range(detection), severity_unit(detection)
    if not shown:
        return None
    tables = []
    for place, (name, found) in enumerate(shown, 1):
        if any(each.alone or each.total for each in found.each):
            tables.append(_shares_table(place, name, found))
        if tested and any(each.reach for each in found.each):
            tables.append(_faults_table(place, name, by_reach(found, MOST_ROWS), tested, unit))
    figures = ("tornado",) if any("faults" in table.key for table in tables) else ()
    said = tuple(_sentences(detection, shown))
    return Block("why", "Why: what moves healthy scores", said, tuple(tables), figures)


def _sentences(detection: Detection, shown: list[tuple[str, Nuisances]]) -> Iterator[str]:
    records = detection.records
    alone, base = (
        max((records.rows(each).size for each in records.populations if each.kind is kind), default=0)
        for kind in (Kind.ALONE, Kind.SOBOL)
    )
    yield (
        f"All records here are healthy: {counted(alone, 'record')} with each nuisance alone, and"
        f" {counted(base, 'base point')} for Sobol indices. What differs from record to record on one"
        " actuator (noise, start phase, seeds) differs in all of them and has a row of its own."
    )
    yield (
        "Alone: central 90 % range of the score while only this varies, relative to the range while all vary."
        " First order and total: Sobol indices, without and with interactions. In parentheses: intervals."
    )
    if any(found.together for _, found in shown):
        yield (
            f"As {severity_unit(detection).quantity}: what a healthy record in twenty looks like, or more;"
            " and what it takes to bring the score of another one in twenty back to its healthy median."
            " < and >: beyond the tested ones."
        )
    for refusal in dict.fromkeys(refusal for _, found in shown for refusal in found.refusals):
        yield f"Not stated for some: {refusal}."
    if lost := max(found.n_lost for _, found in shown):
        yield f"Left out because a record has no score: up to {counted(lost, 'base point')}."


def _shares_table(place: int, name: str, found: Nuisances) -> Table:
    rows = _by_share(found, MOST_ROWS)
    rest = len(found.each) - len(rows)
    columns = (
        Column("Nuisance", list(map(nuisance_name, rows)), is_text=True),
        Column("Alone [%]", [_percent(each.alone) for each in rows]),
        Column("First order [%]", [_percent(each.first_order) for each in rows]),
        Column("Total [%]", [_percent(each.total) for each in rows]),
    )
    notes = (f"{counted(rest, 'further nuisance')} in JSON.",) if rest > 0 else ()
    return Table(columns, f"{name}: what moves it without a leak", f"nuisances-{place}", notes)


def _percent(estimate: Estimate | None) -> str:
    """A share in percent with its interval, e.g. ``26 (-4 … 55)``."""
    if estimate is None:
        return HOLE
    value, low, high = (f"{100.0 * part:.0f}" for part in (estimate.value, estimate.low, estimate.high))
    return f"{value} ({low} … {high})".replace("-0 ", "0 ").replace(" ", _GAP)


def _faults_table(
    place: int, name: str, rows: list[tuple[str, Reach]], tested: tuple[float, float], unit: SeverityUnit
) -> Table:
    def end_text(severity: float) -> str:
        if severity == 0.0 or math.isinf(severity):
            sign, nearest = ("<", tested[0]) if severity == 0.0 else (">", tested[1])
            return f"{sign}{two_digits(unit.value(nearest))}"
        return two_digits(unit.value(severity))

    def text(fault: EquivalentFault) -> str:
        """E.g. ``0.17 (0.07–0.32)``, ``<0.01``, ``0.7 (0.3–>1)``."""
        value, low, high = map(end_text, (end(fault), fault.low, fault.high))
        return value if low == high else f"{value} ({low}–{high})".replace(" ", _GAP)

    columns = (
        Column("Nuisance", [label for label, _ in rows], is_text=True),
        Column(f"Looks like{unit.bracket}", [text(reach.imitated) for _, reach in rows]),
        Column(f"Hides{unit.bracket}", [text(reach.hidden) for _, reach in rows]),
    )
    return Table(columns, f"{name}: what moves it, as {unit.quantity}", f"nuisances-as-faults-{place}")


def nuisance_records(detection: Detection, score: str) -> list[dict[str, Any]]:
    """The nuisances of a score as plain data; empty if the study has no records for them."""
    found, unit = nuisances(detection, score), severity_unit(detection)
    return [
        {
            "parameter": each.parameter,
            "alone": _estimate_record(each.alone),
            "first_order": _estimate_record(each.first_order),
            "total": _estimate_record(each.total),
            "imitates": None if each.reach is None else _fault_record(each.reach.imitated, unit),
            "hides": None if each.reach is None else _fault_record(each.reach.hidden, unit),
        }
        for each in (found.each if found else ())
    ]


def _estimate_record(estimate: Estimate | None) -> dict[str, Any] | None:
    if estimate is None:
        return None
    numbers = {name: finite(getattr(estimate, name)) for name in ("value", "low", "high")}
    return {**numbers, "n": estimate.n_record}


def _fault_record(fault: EquivalentFault, unit: SeverityUnit) -> dict[str, Any]:
    """A fault, or the tested one that it lies below or above; an interval is open where its end is None."""
    ends = {name: finite(unit.value(getattr(fault, name))) for name in ("low", "high")}
    return {"place": fault.place, unit.key: unit.value(fault.severity), **ends}
