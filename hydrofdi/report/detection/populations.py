"""What was asked, which records answer, and how reliable these are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.shown_values import shown_value, shown_values
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.evaluation.populations import Kind
from hydrofdi.quality.doubts import DOUBTS, doubts_of
from hydrofdi.records import Channel
from hydrofdi.report.changes import doubt_text
from hydrofdi.report.detection.selection import best_with_sensors
from hydrofdi.report.detection.wording import false_alarms_in_words, probability_in_words, severity_unit
from hydrofdi.report.table import Block, Table, group_breaks
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import MISSING, ExperimentData
from hydrofdi.store.layout.names import MESSAGE, STATUS, VERDICT
from hydrofdi.studies.judgement import Detection
from hydrofdi.studies.reading import study_designs

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
