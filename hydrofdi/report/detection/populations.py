"""What was asked, which records answer, how reliable these are, and what moves healthy scores."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.study import StudyConfig
from hydrofdi.config.values import shown_value, shown_values
from hydrofdi.evaluation.scores import NOTHING, Kind, comparable
from hydrofdi.records import Channel
from hydrofdi.report.detection import wording
from hydrofdi.report.document import Block
from hydrofdi.settings.messages import HOLE, two_digits
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import MISSING, STATUS
from hydrofdi.studies.records import Detection, Nuisance, nuisances_of
from hydrofdi.tables.table import Table, group_breaks, numbers

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
    Channel.OIL_TEMPERATURE: "temperature_sensor",
}


def populations_block(detection: Detection, experiment: ExperimentConfig | None) -> Block:
    """The populations, and for a simulated study what varies."""
    study = experiment.study if experiment else None
    tables = [_populations_table(detection, study)]
    if experiment and study:
        drawn = {**study.population.over, **study.population.per_record}
        varied = {name: shown_value(name, own) for name, own in drawn.items() if not name.endswith("seed")}
        title = "What varies in all fault-free populations"
        columns = {"Parameter": [*varied], "Values": [*varied.values()]}
        tables.append(Table.of(columns, title=title, key="varied"))
    return Block("populations", "The records", (_FIT,), tuple(tables))


def _populations_table(detection: Detection, study: StudyConfig | None) -> Table:
    unit, records = wording.severity_unit(detection), detection.records
    changes = {**study.shifts, **study.confusions} if study else {}
    shown = [population for population in records.populations if population.kind is not Kind.ALONE]
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
    nominal, mean = f"{unit.quantity.capitalize()}{unit.bracket}", f"True mean{unit.bracket}"
    heads = ("Population", "Kind", "Records", nominal, mean, "What differs")
    breaks = group_breaks([_GROUPS.get(each.kind) for each in shown])
    columns = dict(zip(heads, zip(*rows, strict=True), strict=True))
    return Table.of(columns, title="Populations", key="populations", notes=(note,), breaks=breaks)


def without_noise(experiment: ExperimentConfig, detection: Detection) -> tuple[str, ...]:
    """Symbols of measured signals without noise that the best score with some set of sensors uses.

    The voltage is a command, which is known.
    """
    used = {
        channel for each in wording.best_with_sensors(detection).values() for channel in each.scored.channels
    }
    drawn = experiment.study.population.over if experiment.study else {}
    chosen = {**detection.records.design, **drawn}
    return tuple(
        channel.symbol
        for channel, section in _SECTIONS.items()
        if channel.value in used
        and not any(
            chosen.get(name, experiment.value(name))
            for name in (f"{section}.noise", f"{section}.noise_density")
        )
    )


def n_computed_of(data: ExperimentData) -> int:
    """Runs that are computed."""
    return int((data.columns[STATUS].astype(str) != MISSING).sum())


_FIT = "Thresholds are set only on healthy fit records, results come from others."
_WHY = (
    "All records here are healthy; what differs from record to record on one actuator has a row of its own."
    " Alone: central 90 % range of the score while only this varies, relative to the range while all vary,"
    " with its interval. Looks like: the severity that a healthy record in twenty looks like, or more."
    " Further nuisances are in JSON."
)
_MOST, _MOST_ROWS = 8, 6
"""Scores that are shown, and nuisances of each."""


@lru_cache(maxsize=1024)
def nuisances(detection: Detection, score: str) -> tuple[list[Nuisance], list[str]]:
    """The nuisances of a score by its name, and what is refused; empty without records for them."""
    (scored,) = (judgement.scored for judgement in detection.judgements if judgement.name == score)
    return nuisances_of(detection.records, scored, confidence=detection.rules.confidence)


def why_block(detection: Detection) -> Block | None:
    """Which nuisance moves which score, the best with each set of sensors; None without records for it."""
    best = wording.best_with_sensors(detection).values()
    chosen = dict.fromkeys((*best, *wording.wavelet_rules(detection), *detection.judgements[:1]))
    by_score = {each.name: nuisances(detection, each.name) for each in [*chosen][:_MOST]}
    shown, unit = {name: own for name, (own, _) in by_score.items() if own}, wording.severity_unit(detection)
    if not shown:
        return None

    def size(nuisance: Nuisance) -> float:
        return float(comparable(nuisance.alone.value)) if nuisance.alone else -math.inf

    def texts(nuisance: Nuisance) -> tuple[str, str, str]:
        """A share in percent with its interval, such as ``26 (4 … 55)``, and the leak that it looks like."""
        alone, leak, share, looks = nuisance.alone, nuisance.imitated, HOLE, HOLE
        if alone is not None:
            value, low, high = (f"{100.0 * part:.0f}" for part in (alone.value, alone.low, alone.high))
            share = f"{value} ({low} … {high})".replace(" ", "\N{NO-BREAK SPACE}")
        if leak is not None:
            sign = {"below": "<", "above": ">"}.get(leak.place, "")
            looks = sign + two_digits(unit.value(leak.severity))
        return "record to record" if nuisance.parameter == NOTHING else nuisance.parameter, share, looks

    rows = [
        (name, *texts(each))
        for name, own in shown.items()
        for each in [*sorted(own[:-1], key=size, reverse=True)[:_MOST_ROWS], *own[-1:]]
    ]
    heads = ("Score", "Nuisance", "Alone [%]", f"Looks like{unit.bracket}")
    columns = dict(zip(heads, zip(*rows, strict=True), strict=True))
    table = Table.of(columns, key="nuisances", n_lead=2, breaks=group_breaks([name for name, *_ in rows]))
    refused = dict.fromkeys(refusal for _, refusals in by_score.values() for refusal in refusals)
    said = (_WHY, *(f"Not stated for some: {refusal}." for refusal in refused))
    return Block("why", "Why: what moves healthy scores", said, (table,))


def nuisance_records(detection: Detection, score: str) -> list[dict[str, Any]]:
    """The nuisances of a score as plain data; empty if the study has no records for them."""
    unit = wording.severity_unit(detection)
    return [
        {
            "parameter": each.parameter,
            "alone": each.alone and numbers(each.alone, "value", "low", "high") | {"n": each.alone.n_record},
            "imitates": each.imitated
            and {"place": each.imitated.place, unit.key: unit.value(each.imitated.severity)},
        }
        for each in nuisances(detection, score)[0]
    ]
