"""Why a score raises false alarms and misses leaks: what moves it without a leak."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest

from hydrofdi.evaluation.populations import Kind
from hydrofdi.evaluation.sensitivity.response import Reach
from hydrofdi.report.detection.nuisances import (
    TOGETHER,
    TestedRange,
    by_reach,
    by_share,
    nuisance_name,
    nuisances,
    percent_text,
    tested_range,
)
from hydrofdi.report.detection.selection import best_of_sensors, distinct, wavelet_rules
from hydrofdi.report.detection.wording import severity_unit
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Detection
from hydrofdi.studies.nuisances import Nuisance, Nuisances

MOST, MOST_ROWS = 8, 6
"""Scores that are shown, and nuisances of each."""

Shown = list[tuple[str, Nuisances]]


def shown_nuisances(detection: Detection) -> Shown:
    """The nuisances of the best score with each set of sensors and of the wavelet rules."""
    chosen = distinct(*best_of_sensors(detection), *wavelet_rules(detection), *detection.judgements[:1])
    names = [each.scored.name for each in chosen][:MOST]
    return [(name, found) for name in names if (found := nuisances(detection, name)) is not None]


def why_block(detection: Detection) -> Block | None:
    """Which nuisance moves which score; None if the study has no records for it."""
    shown, tested = shown_nuisances(detection), tested_range(detection)
    if not shown:
        return None
    shares = [
        _shares_sheet(place, *row) for place, row in enumerate(shown, 1) if any(map(_is_shared, row[1].each))
    ]
    faults = [
        _faults_sheet(place, *row, tested)
        for place, row in enumerate(shown, 1)
        if tested and any(each.reach for each in row[1].each)
    ]
    return Block(
        "why",
        "Why: what moves healthy scores",
        tuple(_sentences(detection, shown)),
        tuple(sheet for pair in zip_longest(shares, faults) for sheet in pair if sheet is not None),
        ("tornado",) if faults else (),
    )


def _is_shared(nuisance: Nuisance) -> bool:
    return nuisance.alone is not None or nuisance.total is not None


def _sentences(detection: Detection, shown: Shown) -> Iterator[str]:
    alone, base = (_largest(detection, kind) for kind in (Kind.ALONE, Kind.SOBOL))
    yield (
        f"All records here are healthy: {counted(alone, 'record')} with each nuisance alone, and"
        f" {counted(base, 'base point')} for Sobol indices. What differs from record to record on one"
        " actuator (noise, start phase, seeds) differs in all of them and has a row of its own."
    )
    yield (
        "Alone: central 90 % range of the score while only this varies, relative to the range while all "
        "vary. First"
        " order and total: Sobol indices, without and with interactions. In parentheses: intervals."
    )
    if any(found.together for _, found in shown):
        quantity = severity_unit(detection).quantity
        yield (
            f"As {quantity}: what a healthy record in twenty looks like, or more; and what it takes to bring"
            " the score of another one in twenty back to its healthy median. < and >: beyond the tested ones."
        )
    for name, found in shown:
        yield from _most(name, found)
    for refusal in dict.fromkeys(refusal for _, found in shown for refusal in found.refusals):
        yield f"Not stated for some: {refusal}."
    lost = max(found.n_lost for _, found in shown)
    if lost:
        yield f"Left out because a record has no score: up to {counted(lost, 'base point')}."


def _largest(detection: Detection, kind: Kind) -> int:
    """Records of the largest population of a kind."""
    records = detection.records
    return max((records.rows(each).size for each in records.populations if each.kind is kind), default=0)


def _most(name: str, found: Nuisances) -> Iterator[str]:
    first = by_share(found, 1)[0]
    parts = []
    if first.total is not None:
        parts.append(f"{percent_text(first.total)} % of its variance")
    if first.alone is not None:
        parts.append(f"alone {percent_text(first.alone)} % of its healthy spread")
    if parts:
        yield f"{name} is moved most by {nuisance_name(first)}: {', '.join(parts)}."


def _shares_sheet(place: int, name: str, found: Nuisances) -> Sheet:
    rows = tuple(_shares(each) for each in by_share(found, MOST_ROWS))
    headers = ("Nuisance", "Alone [%]", "First order [%]", "Total [%]")
    title = f"{name}: what moves it without a leak"
    return Sheet(f"nuisances-{place}", title, headers, rows, (), (0,), _left_out(found, rows))


def _shares(nuisance: Nuisance) -> tuple[Cell, ...]:
    shares = (nuisance.alone, nuisance.first_order, nuisance.total)
    values = [None if share is None else 100.0 * share.value for share in shares]
    cells = (Cell(percent_text(share), value=value) for share, value in zip(shares, values, strict=True))
    return Cell(nuisance_name(nuisance)), *cells


def _faults_sheet(place: int, name: str, found: Nuisances, tested: TestedRange) -> Sheet:
    unit = tested.unit
    named = [(nuisance_name(each), each.reach) for each in by_reach(found, MOST_ROWS)]
    rows = tuple(_reach(*row, tested) for row in ((TOGETHER, found.together), *named))
    shown = f" [{unit.name}]" if unit.name else ""
    headers = ("Nuisance", f"Looks like{shown}", f"Hides{shown}")
    title = f"{name}: what moves it, as {unit.quantity}"
    return Sheet(f"nuisances-as-faults-{place}", title, headers, rows, (), (0,))


def _reach(label: str, reach: Reach | None, tested: TestedRange) -> tuple[Cell, ...]:
    faults = (None, None) if reach is None else (reach.imitated, reach.hidden)
    return Cell(label), *(Cell(tested.text(fault)) for fault in faults)


def _left_out(found: Nuisances, rows: tuple[object, ...]) -> str:
    rest = len(found.each) - len(rows)
    return f"{counted(rest, 'further nuisance')} in JSON." if rest > 0 else ""
