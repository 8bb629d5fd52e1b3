"""What was asked, which records answer, how reliable these are, and what moves healthy scores."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.shown_values import shown_value, shown_values
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.evaluation.scores import NOTHING, Kind
from hydrofdi.evaluation.sensitivity import EquivalentFault, Reach, Spread
from hydrofdi.quality.doubts import DOUBTS, doubts_of
from hydrofdi.records import Channel
from hydrofdi.report.changes import doubt_text
from hydrofdi.report.detection.wording import (
    SeverityUnit,
    best_with_sensors,
    distinct,
    false_alarms_in_words,
    probability_in_words,
    severity_unit,
    wavelet_rules,
)
from hydrofdi.report.table import Block, Column, Table, finite, group_breaks
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.store.experiment_data import MISSING, ExperimentData
from hydrofdi.store.layout.names import MESSAGE, STATUS, VERDICT
from hydrofdi.studies.parts import Nuisance, Nuisances, nuisances_of
from hydrofdi.studies.reading import study_designs
from hydrofdi.studies.records import Detection

_KINDS = {
    (Kind.HEALTHY, True): "healthy, for thresholds",
    (Kind.HEALTHY, False): "healthy, for testing",
    (Kind.FAULT, True): "leaking, for training",
    (Kind.FAULT, False): "leaking, for testing",
    (Kind.SHIFT, False): "healthy, shifted",
    (Kind.CONFUSION, False): "another fault",
}
_GROUPS = {Kind.HEALTHY: "healthy", Kind.FAULT: "leaking"}
_SECTIONS = {
    Channel.CHAMBER_1_PRESSURE: "pressure_1_sensor",
    Channel.CHAMBER_2_PRESSURE: "pressure_2_sensor",
    Channel.SUPPLY_PRESSURE: "supply_sensor",
    Channel.PISTON_POSITION: "position_sensor",
    Channel.PISTON_VELOCITY: "velocity_sensor",
    Channel.SPOOL_POSITION: "spool_sensor",
    Channel.INPUT_VOLTAGE: "voltage_sensor",
}
_MOST = 20
"""Reasons that are listed one by one."""


class Sensor(NamedTuple):
    """A sensor of some score as it is simulated: what it adds to the signal, empty if nothing."""

    channel: Channel
    noise: str
    bias: str
    bits: str


def populations_block(detection: Detection, experiment: ExperimentConfig | None) -> Block:
    """The question, the populations, and for a simulated study its sensors and what varies."""
    asked, unit = detection.rules, severity_unit(detection)
    question = (
        f"Which {unit.quantity} is found {probability_in_words(asked.probability)}, with"
        f" {100.0 * asked.confidence:g} % confidence, at {false_alarms_in_words(asked.false_alarm_rate)},"
        " and with which score? Thresholds are set only on healthy fit records; all results come from "
        "records that nothing was fitted to."
    )
    study = experiment.study if experiment else None
    tables = [_populations_table(detection, study)]
    if experiment and study:
        drawn = {**study.population.over, **study.population.per_record}
        varied = {name: shown_value(name, own) for name, own in drawn.items() if not name.endswith("seed")}
        title = "What varies in all fault-free populations"
        columns = {"Parameter": [*varied], "Values": [*varied.values()]}
        tables += [_sensors_table(experiment, detection), Table.of(columns, title=title, key="varied")]
    return Block("populations", "The question", (question,), tuple(tables))


def _populations_table(detection: Detection, study: StudyConfig | None) -> Table:
    unit, records = severity_unit(detection), detection.records
    changes = {**study.shifts, **study.confusions} if study else {}
    shown = [each for each in records.populations if each.kind is not Kind.ALONE]
    rows: list[tuple[Any, ...]] = []
    for each in shown:
        severity = records.severity[records.rows(each)]
        known = severity[np.isfinite(severity)]
        true = unit.value(float(known.mean())) if known.size else None
        kind = _KINDS.get((each.kind, each.is_fit), str(each.kind))
        differs = shown_values(changes.get(each.name, {}))
        rows.append((each.name, kind, severity.size, unit.value(each.severity), true, differs))
    if alone := records.chosen(Kind.ALONE, is_fit=False):
        n = sum(records.rows(each).size for each in alone)
        rows.append(("each nuisance alone", "healthy, for explanation", n, None, None, ""))
    note = f"True mean: mean {unit.quantity} over each record, averaged over the records."
    if unit.name == "L/min":
        note += (
            " With 'calibration: {at: nominal}' it differs from the nominal leakage: K_i is solved once for"
            " the nominal machine, and drawn parameters and loads change the flow."
        )
    nominal, mean = f"{unit.quantity.capitalize()}{unit.bracket}", f"True mean{unit.bracket}"
    names = ("Population", "Kind", "Records", nominal, mean, "What differs")
    breaks = group_breaks([_GROUPS.get(each.kind) for each in shown])
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    return Table.of(columns, title="Populations", key="populations", notes=(note,), breaks=breaks)


def _sensors_table(experiment: ExperimentConfig, detection: Detection) -> Table:
    sensors = sensors_of(experiment, detection)
    columns = {
        "Sensor": [f"{each.channel.symbol} ({_SECTIONS[each.channel]})" for each in sensors],
        "Noise": [each.noise or "none" for each in sensors],
        "Bias": [each.bias or "none" for each in sensors],
        "Bits": [each.bits or "–" for each in sensors],
    }
    return Table.of(columns, title="Sensors that the scores use", key="sensors")


def sensors_of(experiment: ExperimentConfig, detection: Detection) -> tuple[Sensor, ...]:
    """The sensors of all scores that are judged."""
    used = {channel for each in detection.judgements for channel in each.scored.channels}
    drawn = experiment.study.population.over if experiment.study else {}
    chosen = {**detection.records.design, **drawn}

    def text(name: str) -> str:
        value = chosen.get(name, experiment.value(name))
        return shown_value(name, value) if value else ""

    return tuple(
        Sensor(
            channel,
            text(f"{section}.noise") or text(f"{section}.noise_density"),
            text(f"{section}.bias"),
            text(f"{section}.bits"),
        )
        for channel, section in _SECTIONS.items()
        if channel.value in used
    )


def without_noise(experiment: ExperimentConfig, detection: Detection) -> tuple[str, ...]:
    """Symbols of measured signals without noise that the best score with some set of sensors uses.

    The voltage is a command, which is known.
    """
    used = {channel for each in best_with_sensors(detection).values() for channel in each.scored.channels}
    return tuple(
        each.channel.symbol
        for each in sensors_of(experiment, detection)
        if not each.noise and each.channel is not Channel.INPUT_VOLTAGE and each.channel.value in used
    )


def progress_block(data: ExperimentData) -> Block | None:
    """The first section while runs are missing; None if no run is missing."""
    n_computed = n_computed_of(data)
    if n_computed == data.n_run:
        return None
    so_far = " The tables show the runs so far; no conclusions are drawn from them." if n_computed else ""
    sentence = (
        f"{n_computed:,} of {counted(data.n_run, 'run')} are computed; 'hydrofdi sweep CONFIG' computes the"
        f" rest.{so_far}"
    )
    return Block("progress", "Not finished", (sentence,))


def n_computed_of(data: ExperimentData) -> int:
    """Runs that are computed."""
    return int((data.columns[STATUS].astype(str) != MISSING).sum())


def holes_block(data: ExperimentData) -> Block | None:
    """How many of the computed runs have no numbers, and why; None if all have."""
    statuses, messages = (data.columns[name].astype(str).tolist() for name in (STATUS, MESSAGE))
    found = [(status, why) for status, why in zip(statuses, messages, strict=True)
             if status not in ("ok", MISSING)]  # fmt: skip
    if not found:
        return None
    kinds = ", ".join(f"{n:,} {status}" for status, n in Counter(status for status, _ in found).items())
    reasons = Counter(why for _, why in found if why)
    lines = [f"{counted(n, 'run')}: {why}" for why, n in reasons.most_common(_MOST)]
    rest = len(reasons) - _MOST
    more = [f"… and {counted(rest, 'more reason')}."] if rest > 0 else []
    of = counted(n_computed_of(data), "run")
    first = f"{len(found):,} of {of} have no results and are not counted in any rate: {kinds}."
    return Block("holes", "What is missing", (first, *lines, *more))


def doubts_block(data: ExperimentData) -> Block | None:
    """A sentence on each verdict, with its populations and the remedy; None if all records are ok."""
    verdicts = np.asarray(data.columns.get(VERDICT, ())).astype(str)
    if not verdicts.size:
        return None
    totals: Counter[str] = Counter()
    with_doubt: dict[str, Counter[str]] = {word: Counter() for word in DOUBTS}
    for records, rows in study_designs(data):
        for place, row in zip(records.of_record.tolist(), rows.tolist(), strict=True):
            totals[records.populations[place].name] += 1
            for doubt in doubts_of(verdicts[row]):
                with_doubt[doubt.word][records.populations[place].name] += 1
    said = tuple(_verdict(data, word, own, totals) for word, own in with_doubt.items() if own)
    return Block("doubts", "How reliable the records are", said) if said else None


def _verdict(data: ExperimentData, word: str, own: Mapping[str, int], totals: Mapping[str, int]) -> str:
    n_own, n_record = sum(own.values()), sum(totals.values())
    parts = [f"{own[name]:,} of {total:,} '{name}'" for name, total in totals.items() if name in own]
    where = "; ".join(parts) if n_own < n_record else "all of each population"
    worst = float(np.nanmax(np.asarray(data.columns[DOUBTS[word].number], dtype=float)))
    verb = "is" if n_own == 1 else "are"
    of = counted(n_record, "record")
    return f"{n_own:,} of {of} {verb} {word} ({where}): {doubt_text(DOUBTS[word], worst)}"


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
