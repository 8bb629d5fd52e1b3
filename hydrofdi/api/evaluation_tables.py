"""Scores of labelled records as tables, and as plain data for JSON; missing numbers are None."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import HealthyPair, Rate
from hydrofdi.evaluation.roc import Area
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.table import Column, Table
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE, number_text
from hydrofdi.studies.judgement import Detection, Judgement, found_from
from hydrofdi.studies.parts import records_without_number
from hydrofdi.studies.records import StudyRecords
from hydrofdi.units import convert

Pairs = Mapping[str, tuple[HealthyPair, ...]]
"""Name of a score → every healthy group against every other."""

_WORDS = ("score", "population", "kind", "unit")
_NUMBERS = {
    **dict.fromkeys(("low", "high", "alarms", "n", "rate", "rate_low", "rate_high"), ("", "")),
    "auc": ("", "AUC"),
    **dict.fromkeys(("auc_low", "auc_high"), ("", "")),
    "q90_95": ("m^3/s", "q90/95 [L/min]"),
    "without_number": ("", "without a number"),
}
"""Column → unit and title."""


def scores_table(detection: Detection, pairs: Pairs) -> Table:
    """A row for each score and population; ~ marks scores by which healthy groups differ as faults do."""
    rows = [
        row
        for each in detection.judgements
        for row in _rows(detection.records, each, pairs[each.scored.name])
    ]

    def column(name: str, unit: str = "", title: str = "") -> Column:
        texts = [row["texts"].get(name, HOLE) for row in rows]
        is_shown, is_text = bool({*texts} - {HOLE}), name in _WORDS
        text = texts if is_shown else number_text
        values = [row[name] for row in rows]
        return Column(name, values, unit, title, text, is_text=is_text, is_shown=is_shown)

    firsts = [at for at, row in enumerate(rows) if at and row["score"] != rows[at - 1]["score"]]
    return Table(
        (*map(column, _WORDS), *(column(name, *more) for name, more in _NUMBERS.items())),
        n_lead=2,
        breaks=firsts if len(rows) > 2 * len(detection.judgements) else (),
    )


def _rows(
    records: StudyRecords, judgement: Judgement, pairs: Sequence[HealthyPair]
) -> Iterator[dict[str, Any]]:
    areas = {level.population: level.area for level in judgement.levels}
    rates = {**judgement.false_alarms, **{each.population: each.detected for each in judgement.levels}}
    limits, smallest = judgement.threshold, judgement.smallest.get("q90_95")
    missing = records_without_number(records, judgement.scored)
    name, between = judgement.scored.name, [pair.area.value for pair in pairs]
    for population, rate in rates.items():
        area, is_healthy = areas.get(population), population.kind == "healthy"
        told = {} if rate is None else _rate_record(judgement, population, rate)
        ends = {} if area is None else _area_record(area)
        texts = {
            "score": f"~ {name}" if stands_clear(judgement, pairs) is False else name,
            "population": population.name,
        }
        if rate is not None:
            texts["alarms"] = _rate_text(rate, digits=int(is_healthy), is_stated=told["rate"] is not None)
        if area is not None:
            texts["auc"] = _area_text(area)
        elif is_healthy and between:
            texts["auc"] = f"{min(between):.2f} … {max(between):.2f}"
        if smallest is not None and not is_healthy:
            texts["q90_95"] = smallest.sentence(scale=convert(1.0, "L/min"))
        if population.name in missing:
            texts["without_number"] = str(missing[population.name])
        yield {
            "score": name,
            "population": population.name,
            "kind": population.kind.value,
            "unit": judgement.scored.unit,
            "low": limits and limits.low,
            "high": limits and limits.high,
            **{key: told.get(key) for key in ("alarms", "n", "rate")},
            **{f"rate_{end}": told.get(end) for end in ("low", "high")},
            "auc": ends.get("value"),
            **{f"auc_{end}": ends.get(end) for end in ("low", "high")},
            "q90_95": smallest and smallest.value,
            "without_number": missing.get(population.name, 0),
            "texts": texts,
        }


def pairs_table(best: str, found: Sequence[HealthyPair]) -> Table:
    """Healthy groups against each other by the best score; in both orders only if alarms depend on it."""
    pairs = sorted(found, key=lambda pair: -abs(pair.area.value - 0.5))
    has_alarms = any(pair.rate is not None for pair in pairs)
    if not has_alarms:
        pairs = [each for each in pairs if (each.area.value, each.fit_group) > (0.5, each.test_group)]
    ends = [_pair_record(pair) | {"n": pair.rate and pair.rate.total} for pair in pairs]
    titles = ("threshold of", "tested") if has_alarms else ("group", "reads higher")

    def column(name: str, key: str = "", **more: Any) -> Column:
        return Column(name, [each[key or name] for each in ends], **more)

    return Table(
        (
            column("fit_group", title=titles[0], is_text=True),
            column("test_group", title=titles[1], is_text=True),
            column("auc", "value", title="AUC", text=[_area_text(pair.area) for pair in pairs]),
            column("auc_low", "low", is_shown=False),
            column("auc_high", "high", is_shown=False),
            column(
                "alarms",
                title="false alarms",
                text=[f"{pair.rate.count} of {pair.rate.total}" if pair.rate else HOLE for pair in pairs],
                is_shown=has_alarms,
            ),
            column("n", is_shown=False),
        ),
        title=f"Healthy groups against each other by {best}: none of them leaks",
        n_lead=2,
    )


def _area_text(area: Area) -> str:
    return f"{area.value:.2f} [{area.low:.2f}, {area.high:.2f}]"


def _rate_text(rate: Rate, *, digits: int, is_stated: bool) -> str:
    counts = f"{rate.count} of {rate.total}"
    if not is_stated:
        return counts
    value, low, high = (f"{100.0 * share:.{digits}f}" for share in (rate.value, rate.low, rate.high))
    return f"{counts}, {value} % [{low}, {high}]"


def score_record(records: StudyRecords, judgement: Judgement, pairs: Sequence[HealthyPair]) -> dict[str, Any]:
    """What a score finds."""
    scored, threshold = judgement.scored, judgement.threshold
    found = finite(found_from(judgement))
    return {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": None
        if threshold is None
        else {"low": finite(threshold.low), "high": finite(threshold.high), "n": threshold.n_healthy},
        "false_alarms": [
            _rate_record(judgement, each, rate) for each, rate in judgement.false_alarms.items()
        ],
        "auc": [
            {"label": level.population.name} | _area_record(level.area)
            for level in judgement.levels
            if level.area is not None
        ],
        "detected": [
            _rate_record(judgement, level.population, level.detected)
            for level in judgement.levels
            if level.detected is not None
        ],
        "q90_95_L_per_min": None if found is None else convert(found, "L/min"),
        "stands_clear": stands_clear(judgement, pairs),
        "without_number": records_without_number(records, scored),
        "healthy_against_healthy": [_pair_record(each) for each in pairs],
        "refusals": list(judgement.refusals),
        "remarks": list(judgement.remarks),
        "note": scored.note or None,
    }


def _area_record(area: Area) -> dict[str, Any]:
    numbers = {"value": area.value, "low": area.low, "high": area.high}
    return {name: finite(value) for name, value in numbers.items()} | {
        "n_healthy": area.n_healthy,
        "n": area.n_faulty,
    }


def _rate_record(judgement: Judgement, population: Population, rate: Rate) -> dict[str, Any]:
    """Alarms of a population; a rate where there are enough records for one."""
    needed = judgement.counted.get(population)
    stated = [None if needed else finite(value) for value in (rate.value, rate.low, rate.high)]
    return {
        "label": population.name,
        "alarms": rate.count,
        "n": rate.total,
        "not_measurable": rate.not_measurable,
        **dict(zip(("rate", "low", "high"), stated, strict=True)),
        "records_needed": needed,
    }


def _pair_record(pair: HealthyPair) -> dict[str, Any]:
    alarms = None if pair.rate is None else pair.rate.count
    return (
        {"fit_group": pair.fit_group, "test_group": pair.test_group}
        | _area_record(pair.area)
        | {"alarms": alarms, "refusal": pair.refusal or None}
    )


def healthy_spread(pairs: Sequence[HealthyPair]) -> float:
    """The largest distance of an area of healthy groups from 1/2; NaN without any."""
    return max((abs(pair.area.value - 0.5) for pair in pairs), default=math.nan)


def stands_clear(judgement: Judgement, pairs: Sequence[HealthyPair]) -> bool | None:
    """Whether the area of some fault lies further above 1/2 than healthy groups lie from it.

    None if unknown: without two healthy groups.
    """
    if not pairs:
        return None
    areas = [level.area.value - 0.5 for level in judgement.levels if level.area is not None]
    return max(areas, default=0.0) > healthy_spread(pairs)


def ranked_by_control(judgements: Sequence[Judgement], pairs: Pairs) -> tuple[Judgement, ...]:
    """Best first: those that stand clear of their control, then as `ranked`.

    Of areas with the same two digits the one with the smaller healthy spread comes first.
    """

    def place(judgement: Judgement) -> tuple[bool, bool, float, float, float, str]:
        own = pairs[judgement.scored.name]
        area = 0.0 if math.isnan(judgement.middle_area) else judgement.middle_area
        spread = healthy_spread(own) if own else 0.0
        return (
            stands_clear(judgement, own) is False,
            judgement.keeps_its_rate is False,
            found_from(judgement),
            -round(area, 2),
            spread,
            judgement.scored.name,
        )

    return tuple(sorted(judgements, key=place))


def conclusion(judgements: Sequence[Judgement], pairs: Pairs) -> str:
    """What the control says of all scores, in one sentence; empty if there is none."""
    known = [stands_clear(each, pairs[each.scored.name]) for each in judgements if each.levels]
    known = [each for each in known if each is not None]
    n_not, n_score = known.count(False), len(known)
    if not n_score:
        return ""
    if n_not == n_score:
        return (
            "only the unit or the day was detected: in every score, healthy groups differ "
            "from each other as much as faults differ from them"
        )
    if n_not:
        return (
            f"by {n_not} of {counted(n_score, 'score')}, marked ~, healthy"
            " groups differ from each other as much as"
            " faults differ from them: what these detect may be the unit or the day"
        )
    return "by every score, a fault differs from healthy records more than healthy groups from each other"
