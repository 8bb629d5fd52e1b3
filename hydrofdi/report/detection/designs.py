"""Comparison of designs: designs of a study side by side."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from hydrofdi.config.shown_values import shown_value
from hydrofdi.errors import NotStatedError
from hydrofdi.report.detection.record import design_record
from hydrofdi.report.detection.selection import best_with_sensors, wavelet_rules
from hydrofdi.report.detection.wording import sensors, severity_unit
from hydrofdi.report.table import Block, Column, Table, finite
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.designs import Detector, Gain, are_shown, gain
from hydrofdi.studies.judgement import Detection, Judgement

_MOST = 6
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
        return (" ↑" if self.gain.value > 0.0 else " ↓") if self.is_shown else " ="


def designs_block(detections: Sequence[Detection]) -> Block | None:
    """What each design finds with each set of sensors; None for a single design."""
    if len(detections) < 2:
        return None
    unit, rules = severity_unit(detections[0]), detections[0].rules
    confidence = f"{100.0 * rules.confidence:g}"

    sentence = (
        "Each design repeats the study with the same actuators. Columns: the best score with no more than"
        " these sensors in each design, and the wavelet rules."
    )
    note = (
        "↑ and ↓: detects more or fewer of the same leaking actuators than the first design, averaged over"
        " all tested leaks; =: no difference shown, which does not prove that there is none"
        f" ({confidence} % confidence for a column, thresholds resampled)."
    )
    title = f"q{100.0 * rules.probability:g}/{confidence}{unit.bracket}"
    compared = _compared(tuple(detections))
    columns = [Column("Design", [_label(detections, each) for each in detections], is_text=True)]
    for name in [*dict.fromkeys(name for row in compared for name in row)][:_MOST]:
        own = [row.get(name) for row in compared]
        found = (each and unit.found(each.judgement.smallest.get("q90_95")) + each.mark for each in own)
        columns.append(Column(name, [text or HOLE for text in found]))
    table = Table(tuple(columns), title, "designs", (note,), (1,))
    return Block("designs", "Comparison of designs", (sentence,), (table,))


@lru_cache(maxsize=4)
def _compared(detections: tuple[Detection, ...]) -> tuple[Mapping[str, Compared], ...]:
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


def _label(detections: Sequence[Detection], detection: Detection) -> str:
    """What a design changes of the first one, which is named by what it sets."""
    own, first = detection.records.design, detections[0].records.design
    names: dict[str, list[str]] = defaultdict(list)
    for name, value in own.items():
        if detection is detections[0] or first.get(name) != value:
            names[shown_value(name, value)].append(name)
    return ", ".join(f"{', '.join(alike)} = {value}" for value, alike in names.items()) or "as configured"


def design_records(detections: Sequence[Detection]) -> list[dict[str, Any]]:
    """The designs as plain data; empty for a single one."""
    if len(detections) < 2:
        return []
    return [
        {
            "design": design_record(detection),
            "detectors": [_detector_record(detection, name, each) for name, each in row.items()],
        }
        for detection, row in zip(detections, _compared(tuple(detections)), strict=True)
    ]


def _detector_record(detection: Detection, name: str, compared: Compared) -> dict[str, Any]:
    """A detector, and the difference of its rates of detection over all tested severities."""
    scored, unit, own = compared.judgement.scored, severity_unit(detection), compared.gain
    found = compared.judgement.smallest.get("q90_95")
    return {
        "column": name,
        "indicator": scored.name,
        "channels": list(scored.channels),
        f"q90_95{unit.suffix}": None if found is None or found.value is None else unit.value(found.value),
        "gain": own
        and {name: finite(getattr(own, name)) for name in ("value", "low", "high", "p_value")}
        | {"is_shown": compared.is_shown},
    }
