"""Figures of a judged study of detection; one module per figure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from hydrofdi.evaluation.scores import Kind
from hydrofdi.report.detection.wording import (
    answers,
    false_alarms_in_words,
    probability_in_words,
    severity_unit,
)
from hydrofdi.report.figures.detection.curves import draw_det, draw_pod, draw_roc
from hydrofdi.report.figures.detection.delays import draw_delays
from hydrofdi.report.figures.detection.populations import draw_densities, draw_false_alarms
from hydrofdi.report.figures.detection.ranking import draw_answer, draw_ranking
from hydrofdi.report.figures.detection.tornado import draw_tornado
from hydrofdi.report.table import FigureKind
from hydrofdi.studies.charts import RunLengths
from hydrofdi.studies.records import Detection

_DRAWN: dict[str, Callable[[Detection], Any]] = {
    "ranking": draw_ranking,
    "answer": draw_answer,
    "pod": draw_pod,
    "roc": draw_roc,
    "det": draw_det,
    "false_alarms": draw_false_alarms,
    "densities": draw_densities,
    "tornado": draw_tornado,
}


def detection_figures(detection: Detection, charts: Sequence[RunLengths]) -> dict[str, FigureKind]:
    """The figures of a judged study, and of the first design of its charts."""
    figures = {
        name: FigureKind(caption, partial(_DRAWN[name], detection))
        for name, caption in _captions(detection).items()
        if (name != "tornado" or detection.records.chosen(Kind.ALONE, is_fit=False))
        and (name != "answer" or answers(detection))
    }
    if charts:
        confidence = f"{100.0 * charts[0].confidence:g} %"
        caption = (
            "Median delay from the onset of a leak to the alarm, over the mean time between false alarms"
            f" that limits are set for, with {confidence} intervals; a panel for each leak."
            " Lines end where half of the leaks are not found before their records end"
        )
        figures["delays"] = FigureKind(caption, partial(draw_delays, charts[0]))
    return figures


def _captions(detection: Detection) -> dict[str, str]:
    asked, quantity = detection.rules, severity_unit(detection).quantity
    rate, confidence = f"{100.0 * asked.false_alarm_rate:g} %", f"{100.0 * asked.confidence:g} %"
    share = f"{100.0 * asked.probability:g} %"
    ends = "vertical line: the rate that thresholds are set for"
    on_axes = f"on normal-deviate axes; dashed: chance; {ends}. Lines end where no record is left on one side"
    return {
        "ranking": f"The {quantity} that each score finds with {share} probability: the estimate (open) and"
        f" the bound with {confidence} confidence (filled), at thresholds for {rate} false alarms; → not"
        " found up to the largest tested; ← at most the smallest tested; in brackets: exceeds its"
        " false-alarm rate",
        "pod": f"Share of records detected over their {quantity}: tested levels with {confidence} intervals,"
        f" the fitted curve and its one-sided {confidence} lower bound (dashed), which reaches {share}"
        " (horizontal line) at q90/95 (vertical line); dotted: the false-alarm rate of the threshold. No"
        " curve: it does not describe the hits and misses; then the tested levels say what is found",
        "roc": f"Detections against false alarms over all thresholds, {on_axes}; dots: the threshold in use",
        "det": f"Misses against false alarms over all thresholds, for each tested {quantity}, {on_axes}",
        "false_alarms": f"Alarms of records whose seal is sound, with {confidence} intervals; {ends}; open:"
        " too few records for a rate",
        "densities": "Scores of healthy, shifted and leaking records, each scaled to its own largest density;"
        " arrows: the share beyond the axis; vertical lines: thresholds",
        "tornado": f"What each nuisance alone does to a healthy score, expressed as the {quantity} that "
        "would do"
        " the same. Right: what a healthy record in twenty looks like; left: what another one hides. Lines:"
        f" {confidence} intervals; dotted: the smallest and the largest tested, beyond which nothing is said",
        "answer": f"The smallest {quantity} that is found {probability_in_words(asked.probability)}, with"
        f" {confidence} confidence, at {false_alarms_in_words(asked.false_alarm_rate)}: the best score with"
        " each set of sensors that finds more than a part of the set",
    }
