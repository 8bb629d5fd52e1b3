"""What moves healthy scores, and so causes false alarms and missed leaks: sentences, tables, plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from hydrofdi.evaluation.populations import NOTHING, Kind
from hydrofdi.evaluation.sensitivity import EquivalentFault, Reach, Spread
from hydrofdi.report.detection.selection import best_with_sensors, distinct, wavelet_rules
from hydrofdi.report.detection.wording import SeverityUnit, severity_unit
from hydrofdi.report.table import Block, Column, Table, finite
from hydrofdi.settings.messages import counted
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


def foremost_nuisances(found: Nuisances, most: int) -> list[tuple[str, Spread | None, Reach | None]]:
    """All together, the nuisances that look like or hide the largest faults, and record to record."""

    def size(nuisance: Nuisance) -> tuple[float, ...]:
        alone, reach = nuisance.alone, nuisance.reach
        ends = [end(fault) for fault in (reach.imitated, reach.hidden)] if reach else [-math.inf]
        return max(ends), min(ends), alone.value if alone else -math.inf

    ordered = sorted(found.each, key=size, reverse=True)
    first = [*ordered[:most], *(each for each in ordered[most:] if each.parameter == NOTHING)]
    together = [(TOGETHER, None, found.together)] if found.together else []
    return together + [
        ("record to record" if each.parameter == NOTHING else each.parameter, each.alone, each.reach)
        for each in first
    ]


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
    tables = tuple(_table(place, name, found, tested, unit) for place, (name, found) in enumerate(shown, 1))
    figures = ("tornado",) if any(found.together for _, found in shown) else ()
    return Block(
        "why", "Why: what moves healthy scores", tuple(_sentences(detection, shown)), tables, figures
    )


def _sentences(detection: Detection, shown: list[tuple[str, Nuisances]]) -> Iterator[str]:
    records = detection.records
    alone = max(records.rows(each).size for each in records.populations if each.kind is Kind.ALONE)
    yield (
        f"All records here are healthy: {counted(alone, 'record')} with each nuisance alone. What differs"
        " from record to record on one actuator (noise, start phase, seeds) has a row of its own. Alone:"
        " central 90 % range of the score while only this varies, relative to the range while all vary. In"
        " parentheses: intervals."
    )
    if any(found.together for _, found in shown):
        yield (
            f"As {severity_unit(detection).quantity}: what a healthy record in twenty looks like, or more;"
            " and what it takes to bring the score of another one in twenty back to its healthy median."
            " < and >: beyond the tested ones."
        )
    for refusal in dict.fromkeys(refusal for _, found in shown for refusal in found.refusals):
        yield f"Not stated for some: {refusal}."


def _table(
    place: int, name: str, found: Nuisances, tested: tuple[float, float] | None, unit: SeverityUnit
) -> Table:
    def end_text(severity: float) -> str:
        if tested and (severity == 0.0 or math.isinf(severity)):
            sign, nearest = ("<", tested[0]) if severity == 0.0 else (">", tested[1])
            return f"{sign}{two_digits(unit.value(nearest))}"
        return two_digits(unit.value(severity))

    def text(fault: EquivalentFault | None) -> str:
        """E.g. ``0.17 (0.07–0.32)``, ``<0.01``, ``0.7 (0.3–>1)``."""
        if fault is None:
            return HOLE
        value, low, high = map(end_text, (end(fault), fault.low, fault.high))
        return value if low == high else f"{value} ({low}–{high})".replace(" ", _GAP)

    rows = foremost_nuisances(found, MOST_ROWS)
    columns = [
        Column("Nuisance", [label for label, *_ in rows], is_text=True),
        Column("Alone [%]", [alone for _, alone, _ in rows], text=_percent),
    ]
    if found.together:
        imitated = [text(reach.imitated if reach else None) for *_, reach in rows]
        hidden = [text(reach.hidden if reach else None) for *_, reach in rows]
        columns += [Column(f"Looks like{unit.bracket}", imitated), Column(f"Hides{unit.bracket}", hidden)]
    rest = len(found.each) - MOST_ROWS - 1
    notes = (f"{counted(rest, 'further nuisance')} in JSON.",) if rest > 0 else ()
    return Table(tuple(columns), f"{name}: what moves it without a leak", f"nuisances-{place}", notes)


def _percent(spread: Spread | None) -> str:
    """A share in percent with its interval, e.g. ``26 (4 … 55)``."""
    if spread is None:
        return HOLE
    value, low, high = (f"{100.0 * part:.0f}" for part in (spread.value, spread.low, spread.high))
    return f"{value} ({low} … {high})".replace(" ", _GAP)


def nuisance_records(detection: Detection, score: str) -> list[dict[str, Any]]:
    """The nuisances of a score as plain data; empty if the study has no records for them."""
    found, unit = nuisances(detection, score), severity_unit(detection)
    return [
        {
            "parameter": each.parameter,
            "alone": each.alone
            and {
                "value": finite(each.alone.value),
                "low": finite(each.alone.low),
                "high": finite(each.alone.high),
                "n": each.alone.n_record,
            },
            "imitates": None if each.reach is None else _fault_record(each.reach.imitated, unit),
            "hides": None if each.reach is None else _fault_record(each.reach.hidden, unit),
        }
        for each in (found.each if found else ())
    ]


def _fault_record(fault: EquivalentFault, unit: SeverityUnit) -> dict[str, Any]:
    """A fault, or the tested one that it lies below or above; an interval is open where its end is None."""
    ends = {name: finite(unit.value(getattr(fault, name))) for name in ("low", "high")}
    return {"place": fault.place, unit.key: unit.value(fault.severity), **ends}
