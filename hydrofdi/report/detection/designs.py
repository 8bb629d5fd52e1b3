"""Comparison of designs: designs of a study side by side."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from hydrofdi.config.shown_values import shown_value
from hydrofdi.evaluation.populations import Kind
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.report.detection.record import design_record
from hydrofdi.report.detection.selection import best_with_sensors, tested, wavelet_rules
from hydrofdi.report.detection.wording import found_cell, rate_cell, sensors, severity_unit
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.report.forms.numbers import finite
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.designs import Detector, Gain, are_shown, gain
from hydrofdi.studies.judgement import Detection, Judgement

MOST = 6
"""Columns of detectors."""


@dataclass(frozen=True)
class Compared:
    """A detector of a design against that of the first design.

    Attributes
    ----------
    judgement : Judgement
    gain : Gain or None
        None in the first design, and where nothing is stated.
    is_shown : bool
        Whether the records show a difference, among all designs.
    """

    judgement: Judgement
    gain: Gain | None
    is_shown: bool

    @property
    def mark(self) -> str:
        """↑ detects more than in the first design, ↓ less, = no difference shown."""
        if self.gain is None:
            return ""
        return ("↑" if self.gain.value > 0.0 else "↓") if self.is_shown else "="


Table = tuple[Mapping[str, Compared], ...]


def designs_block(detections: Sequence[Detection]) -> Block | None:
    """What each design finds with each set of sensors; None for a single design."""
    if len(detections) < 2:
        return None
    unit, rules = severity_unit(detections[0]), detections[0].rules
    shown = f" [{unit.name}]" if unit.name else ""
    confidence, share = f"{100.0 * rules.confidence:g} %", f"{100.0 * rules.probability:g}"
    sentence = (
        "Each design repeats the study with the same actuators. Columns: the best score with no more than"
        " these sensors in each design, and the wavelet rules."
    )
    note = (
        "↑ and ↓: detects more or fewer of the same leaking actuators than the first design, averaged over"
        " all tested leaks; =: no difference shown, which does not prove that there is none"
        f" ({confidence} confidence for a column, thresholds resampled)."
    )
    found = _sheet("designs", f"q{share}/{100.0 * rules.confidence:g}{shown}", detections, _found_cell, note)
    alarms = _sheet(
        "designs-false-alarms", "False alarms [%] of healthy test records", detections, _alarm_cell, ""
    )
    return Block("designs", "Comparison of designs", (sentence,), (found, alarms))


@lru_cache(maxsize=4)
def compared_designs(detections: tuple[Detection, ...]) -> Table:
    """Column → detector, for each design; each column is a question of its own, and corrected by itself."""
    rows, confidence = [_columns(detection) for detection in detections], detections[0].rules.confidence
    table: list[dict[str, Compared]] = [{} for _ in rows]
    for name in dict.fromkeys(name for row in rows for name in row):
        own = [row.get(name) for row in rows]
        gains = [None, *(_gain(own[0], each, confidence) for each in own[1:])]
        for cells, detector, found, is_shown in zip(table, own, gains, are_shown(gains), strict=True):
            if detector is not None:
                cells[name] = Compared(detector.judgement, found, is_shown)
    return tuple(table)


def design_records(detections: Sequence[Detection]) -> list[dict[str, Any]]:
    """The designs as plain data; empty for a single one."""
    if len(detections) < 2:
        return []
    unit = severity_unit(detections[0])
    return [
        {
            "design": design_record(detection),
            "detectors": [
                {
                    "column": name,
                    "indicator": each.judgement.scored.name,
                    "channels": list(each.judgement.scored.channels),
                    f"q90_95{unit.suffix}": found_cell(each.judgement.smallest.get("q90_95"), unit).value,
                    "gain": _gain_record(each),
                }
                for name, each in row.items()
            ],
        }
        for detection, row in zip(detections, compared_designs(tuple(detections)), strict=True)
    ]


def _gain_record(compared: Compared) -> dict[str, Any] | None:
    """The difference of the rates of detection over all tested severities."""
    own = compared.gain
    if own is None:
        return None
    numbers = {name: finite(getattr(own, name)) for name in ("value", "low", "high", "p_value")}
    return {**numbers, "is_shown": compared.is_shown}


def _columns(detection: Detection) -> dict[str, Detector]:
    names = {frozenset(each.scored.channels): sensors(each) for each in detection.judgements}
    best = {names[channels]: each for channels, each in best_with_sensors(detection).items()}
    rules = {each.scored.name: each for each in wavelet_rules(detection)}
    return {name: Detector(detection.records, each) for name, each in (best | rules).items()}


def _gain(reference: Detector | None, other: Detector | None, confidence: float) -> Gain | None:
    if reference is None or other is None:
        return None
    try:
        return gain(reference, other, confidence=confidence)
    except NotStatedError:
        return None


def _sheet(
    key: str,
    title: str,
    detections: Sequence[Detection],
    cell: Callable[[Detection, Compared], Cell],
    note: str,
) -> Sheet:
    table = compared_designs(tuple(detections))
    names = list(dict.fromkeys(name for row in table for name in row))[:MOST]
    rows = tuple(
        (
            Cell(_label(detections, detection)),
            *(cell(detection, row[name]) if name in row else Cell(HOLE) for name in names),
        )
        for detection, row in zip(detections, table, strict=True)
    )
    return Sheet(key, title, ("Design", *names), rows, (1,), (0,), note)


def _found_cell(detection: Detection, compared: Compared) -> Cell:
    found = found_cell(compared.judgement.smallest.get("q90_95"), severity_unit(detection))
    return Cell(f"{found.text} {compared.mark}".rstrip(), compared.is_shown, found.value)


def _alarm_cell(detection: Detection, compared: Compared) -> Cell:
    healthy = tested(detection, Kind.HEALTHY)
    return rate_cell(compared.judgement, healthy[0]) if healthy else Cell(HOLE)


def _label(detections: Sequence[Detection], detection: Detection) -> str:
    """What a design changes of the first one, which is named by what it sets."""
    own, first = detection.records.design, detections[0].records.design
    changed = {
        name: value for name, value in own.items() if detection is detections[0] or first.get(name) != value
    }
    names: dict[str, list[str]] = defaultdict(list)
    for name, value in changed.items():
        names[shown_value(name, value)].append(name)
    return ", ".join(f"{', '.join(alike)} = {value}" for value, alike in names.items()) or "as configured"
