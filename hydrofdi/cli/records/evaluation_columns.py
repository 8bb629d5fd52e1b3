"""The columns of an evaluation: the results of each score, in numbers that are never cut."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from hydrofdi.cli.folding import folded
from hydrofdi.evaluation.auc import Area
from hydrofdi.evaluation.groups import HealthyPair
from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.evaluation import Evaluation
    from hydrofdi.studies.judgement import Judgement

HOLE = "–"

_GAP = 2
"""Blanks between columns."""


@dataclass(frozen=True)
class _Column:
    """Two lines of heading, and a text for each score."""

    heading: str
    texts: tuple[str, ...]

    @property
    def width(self) -> int:
        return max(len(text) for text in (*self.heading.split("\n"), *self.texts))


def print_scores(console: Console, evaluation: Evaluation, judgements: Sequence[Judgement]) -> None:
    """Print a table of scores; columns that do not fit continue below.

    Long names are folded, numbers never; columns without any entry are omitted. Scores by which healthy
    groups differ as much as faults are marked.
    """
    names = [each.scored.name for each in judgements]
    clear = [evaluation.stands_clear(each) for each in judgements]
    marks = ["~" if each is False else "" for each in clear]
    room = min(max(map(len, names)), max(console.width // 3, 16))
    for part in _parts(_columns(evaluation, judgements), console.width - room - 2):
        table = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0))
        table.add_column("\n  score", width=room + 2)
        for column in part:
            table.add_column(column.heading, no_wrap=True, min_width=column.width)
        for name, mark, *row in zip(names, marks, *(column.texts for column in part), strict=True):
            table.add_row(mark.ljust(2) + "\n  ".join(folded(name, room)), *row)
        console.print(table)


def _columns(evaluation: Evaluation, judgements: Sequence[Judgement]) -> list[_Column]:
    """All columns with an entry: areas and their control, alarms, severities, records without a number."""

    def column(heading: str, text: Callable[[Judgement], str]) -> _Column:
        return _Column(heading, tuple(text(each) for each in judgements))

    faults = [level.population.name for level in judgements[0].levels]
    columns = [
        *(column(f"AUC\n{name}", partial(_area_at, place)) for place, name in enumerate(faults)),
        column("healthy\ngroups", lambda each: _between(evaluation.healthy_pairs(each))),
        *(column(f"detected\n{name}", partial(_detected_at, place)) for place, name in enumerate(faults)),
        column("false\nalarms", _false_alarms),
        column("q90/95\n[L/min]", _found),
        column("without\na number", lambda each: _missing(evaluation.without_number(each))),
    ]
    return [each for each in columns if any(text != HOLE for text in each.texts)]


def _parts(columns: Sequence[_Column], room: int) -> list[list[_Column]]:
    """Columns that fit beside each other."""
    parts: list[list[_Column]] = [[]]
    left = room
    for column in columns:
        if parts[-1] and column.width + _GAP > left:
            parts.append([])
            left = room
        parts[-1].append(column)
        left -= column.width + _GAP
    return parts


def area_text(area: Area | None) -> str:
    """An area with its interval."""
    return HOLE if area is None else f"{area.value:.2f} [{area.low:.2f}, {area.high:.2f}]"


def _between(pairs: Sequence[HealthyPair]) -> str:
    """The range of the areas of healthy groups."""
    areas = [pair.area.value for pair in pairs]
    return f"{min(areas):.2f} … {max(areas):.2f}" if areas else HOLE


def _false_alarms(judgement: Judgement) -> str:
    rates = list(judgement.false_alarms.items())
    return _rate(judgement, *rates[0], digits=1) if rates else HOLE


def _area_at(place: int, judgement: Judgement) -> str:
    return area_text(judgement.levels[place].area)


def _detected_at(place: int, judgement: Judgement) -> str:
    level = judgement.levels[place]
    return HOLE if level.detected is None else _rate(judgement, level.population, level.detected)


def _rate(judgement: Judgement, population: Population, rate: Rate, *, digits: int = 0) -> str:
    """Alarms of all records with a number; also the rate, if there are enough records."""
    counted = f"{rate.count} of {rate.total}"
    if population in judgement.counted:
        return counted
    value, low, high = (f"{100.0 * share:.{digits}f}" for share in (rate.value, rate.low, rate.high))
    return f"{counted}, {value} % [{low}, {high}]"


def _found(judgement: Judgement) -> str:
    bound = judgement.smallest.get("q90_95")
    return HOLE if bound is None else bound.sentence(scale=convert(1.0, "L/min"))


def _missing(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or HOLE
