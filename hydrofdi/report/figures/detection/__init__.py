"""Figures of a judged study of detection; one module per figure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from hydrofdi.report.detection.wording import answers, severity_unit
from hydrofdi.report.document import FigureKind
from hydrofdi.report.figures.detection.curves import draw_pod, draw_roc
from hydrofdi.report.figures.detection.populations import draw_densities, draw_false_alarms
from hydrofdi.report.figures.detection.ranking import draw_answer, draw_delays, draw_ranking
from hydrofdi.studies.records import Detection

_FIGURES: dict[str, tuple[Callable[[Detection], Any], str]] = {
    "ranking": (draw_ranking, "The {quantity} found by each score with {share} probability"),
    "pod": (
        draw_pod,
        "Share of records detected over their {quantity}, with {confidence} intervals, and the fitted curve;"
        " vertical: q90/95 at {share}; dotted: the false-alarm rate of the threshold",
    ),
    "roc": (draw_roc, "Detections against false alarms over all thresholds; dots: the threshold in use"),
    "false_alarms": (
        draw_false_alarms,
        "Alarms of records whose seal is sound, with {confidence} intervals; open: too few records",
    ),
    "densities": (draw_densities, "Scores of each population; vertical lines: thresholds"),
    "answer": (draw_answer, "The smallest {quantity} that is found with each set of sensors"),
    "delays": (
        draw_delays,
        "Median delay from the onset of a leak to the alarm, over the time between false alarms",
    ),
}


def detection_figures(detection: Detection) -> dict[str, FigureKind]:
    """The figures of a judged study, and of its charts."""
    asked = detection.rules
    said = {
        "quantity": severity_unit(detection).quantity,
        "confidence": f"{100.0 * asked.confidence:g} %",
        "share": f"{100.0 * asked.probability:g} %",
    }
    is_there = {"answer": bool(answers(detection)), "delays": bool(detection.charts)}
    return {
        name: FigureKind(caption.format(**said), partial(draw, detection))
        for name, (draw, caption) in _FIGURES.items()
        if is_there.get(name, True)
    }
