"""What was asked, and which records answer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.sensors import Sensor, sensors_sheet
from hydrofdi.report.detection.varied import Varied
from hydrofdi.report.detection.wording import false_alarms_in_words, probability_in_words, severity_unit
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.judgement import Detection

_KINDS = {
    (Kind.HEALTHY, True): "healthy, for thresholds",
    (Kind.HEALTHY, False): "healthy, for testing",
    (Kind.FAULT, True): "leaking, for training",
    (Kind.FAULT, False): "leaking, for testing",
    (Kind.SHIFT, False): "healthy, shifted",
    (Kind.CONFUSION, False): "another fault",
}

_NUISANCES = {Kind.ALONE: "each nuisance alone", Kind.SOBOL: "Sobol design"}

_GROUPS = {Kind.HEALTHY: "healthy", Kind.FAULT: "leaking"}


def populations_block(detection: Detection, varied: Varied, sensors: Sequence[Sensor] = ()) -> Block:
    """The question, and the populations."""
    asked, unit = detection.rules, severity_unit(detection)
    question = (
        f"Which {unit.quantity} is found {probability_in_words(asked.probability)}, with"
        f" {100.0 * asked.confidence:g} % confidence, at {false_alarms_in_words(asked.false_alarm_rate)},"
        " and with which score? Thresholds are set only on healthy fit records; all results come from "
        "records that nothing was fitted to."
    )
    sheets = (_populations_sheet(detection, varied), sensors_sheet(sensors), _varied_sheet(varied))
    return Block("populations", "The question", (question,), sheets)


def _populations_sheet(detection: Detection, varied: Varied) -> Sheet:
    unit = severity_unit(detection)
    populations = [each for each in detection.records.populations if each.kind not in _NUISANCES]
    shown = f" [{unit.name}]" if unit.name else ""
    rows = [_row(detection, each, varied) for each in populations]
    rows += [row for kind in _NUISANCES for row in _nuisance_rows(detection, kind)]
    n_column = 6 if varied.changes else 5
    headers = ("Population", "Kind", "Records", f"{unit.quantity.capitalize()}{shown}", f"True mean{shown}")
    return Sheet(
        "populations",
        "Populations",
        (*headers, "What differs")[:n_column],
        tuple(row[:n_column] for row in rows),
        group_breaks([_GROUPS.get(each.kind) for each in populations]),
        (0, 1, 5)[: n_column - 3],
        _note(detection),
    )


def _note(detection: Detection) -> str:
    unit = severity_unit(detection)
    first = f"True mean: mean {unit.quantity} over each record, averaged over the records."
    if unit.name != "L/min":
        return first
    return (
        f"{first} With 'calibration: {{at: nominal}}' it differs from the nominal {unit.quantity}: K_i is"
        " solved once for the nominal machine, and drawn parameters and loads change the flow."
    )


def _row(detection: Detection, population: Population, varied: Varied) -> tuple[Cell, ...]:
    unit, rows = severity_unit(detection), detection.records.rows(population)
    severity = detection.records.severity[rows]
    known = severity[np.isfinite(severity)]
    nominal = unit.value(population.severity)
    mean = unit.value(float(known.mean())) if known.size else None
    return (
        Cell(population.name),
        Cell(_KINDS.get((population.kind, population.is_fit), str(population.kind))),
        Cell(f"{rows.size:,}", value=float(rows.size)),
        Cell(f"{nominal:.3g}", value=nominal),
        Cell(HOLE if mean is None else f"{mean:.3g}", value=mean),
        Cell(varied.changes.get(population.name, "")),
    )


def _nuisance_rows(detection: Detection, kind: Kind) -> Sequence[tuple[Cell, ...]]:
    """One row for all populations of a kind that shows what nuisances do."""
    own = [each for each in detection.records.populations if each.kind is kind]
    count = sum(len(detection.records.rows(each)) for each in own)
    empty = Cell("")
    row = (Cell(_NUISANCES[kind]), Cell("healthy, for explanation"), Cell(f"{count:,}", value=float(count)))
    return [(*row, empty, empty, empty)] if own else []


def _varied_sheet(varied: Varied) -> Sheet:
    rows = tuple((Cell(name), Cell(text)) for name, text in varied.common.items())
    title = "What varies in all fault-free populations"
    return Sheet("varied", title, ("Parameter", "Values"), rows, text_columns=(0, 1))
