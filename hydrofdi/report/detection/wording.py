"""Severities, rates and sensors as text in a report."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.records import Channel
from hydrofdi.report.document import Cell
from hydrofdi.report.wording import joined
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.judgement import Detection, Judgement
from hydrofdi.studies.records import StudyRecords
from hydrofdi.units import convert

FROM_LEVELS = "°"
"""Marks what comes from the tested levels alone."""

_IN_WORDS = {
    0.1: "one false alarm in ten",
    0.01: "one false alarm in a hundred",
    0.001: "one false alarm in a thousand",
}


@dataclass(frozen=True)
class SeverityUnit:
    """The unit in which a person reads the severities of a study.

    Attributes
    ----------
    name : str
        Such as ``L/min``.
    quantity : str
        What is measured in it.
    key : str
        Start of the keys of plain data.
    suffix : str
        End of the keys of plain data.
    largest : float
        Largest nominal severity that is tested, in SI.
    per_mean_flow : float
        Flow of the same leak at 8 MPa, per mean flow in the record; NaN if unknown.
    """

    name: str
    quantity: str
    key: str
    suffix: str
    largest: float
    per_mean_flow: float = math.nan

    def value(self, severity: float) -> float:
        """A severity in SI, in this unit."""
        return convert(severity, self.name) if self.name == "L/min" else severity

    def text(self, severity: float) -> str:
        """A severity with three digits and its unit."""
        return f"{self.value(severity):.3g} {self.name}".rstrip()

    def which_flow(self, number: str) -> str:
        """Which flow a number is, and that of the same leak at 8 MPa; empty if it is none or unknown."""
        if math.isnan(self.per_mean_flow):
            return ""
        return f" in this motion ({two_digits(float(number) * self.per_mean_flow)} at 8 MPa)"

    def found(self, severity: DetectableSeverity) -> str:
        """A severity that is found, or the largest nominal severity tested if none is, with two digits."""
        is_above = severity.place == "above"
        return two_digits(self.value(min(severity.severity, self.largest) if is_above else severity.severity))


def severity_unit(detection: Detection) -> SeverityUnit:
    """L/min for leakage flows; every other severity keeps its unit."""
    return severity_unit_of(detection.records)


def severity_unit_of(records: StudyRecords) -> SeverityUnit:
    """The same of records."""
    own = records.severity_unit
    levels = records.chosen(Kind.FAULT, is_fit=False)
    largest = max((level.severity for level in levels), default=math.inf)
    if own == "m^3/s":
        keys = ("leakage_L_per_min", "_L_per_min")
        return SeverityUnit("L/min", "leakage", *keys, largest, records.per_mean_flow)
    return SeverityUnit("" if own == "1" else own, "severity", "severity", "", largest)


def sensors(judgement: Judgement) -> str:
    """What a score needs of a machine, such as ``P1 P2 x u``; a hole if it does not say so."""
    return " ".join(symbols(judgement)) or HOLE


def sensors_in_words(judgement: Judgement) -> str:
    """The same in a sentence, such as ``P1 and u`` or ``P1 alone``."""
    needed = symbols(judgement)
    return f"{needed[0]} alone" if len(needed) == 1 else joined(needed)


def score_title(judgement: Judgement) -> str:
    """A score as a title: ``flow_balance, mean leakage`` for ``balance_P1_P2_x_u.mean_leakage``.

    The name that a user gave to an indicator stays, unless it only adds the sensors.
    """
    scored = judgement.scored
    label, _, output = scored.name.partition(".")
    if not output or "(" in label:
        return scored.name.replace("_", " ").replace("(", " (")
    of_sensors = "_" + "_".join(symbols(judgement))
    own = scored.indicator or label.removesuffix(of_sensors)
    return f"{own if label.endswith(of_sensors) else label}, {output.replace('_', ' ')}"


def symbols(judgement: Judgement) -> list[str]:
    """The symbols of the sensors that a score needs, such as ``P1``; other sensors by their names."""
    known = {channel.value: channel.symbol for channel in Channel}
    return [known.get(channel, channel) for channel in judgement.scored.channels]


def found_text(found: DetectableSeverity | None, unit: SeverityUnit) -> str:
    """A severity in a table, such as ``0.012`` or ``0.02°`` (from the tested levels).

    ``≤ 0.01`` is the smallest tested; ``> 1`` is not found up to the largest.
    """
    if found is None:
        return HOLE
    mark = {"below": "≤ ", "within": "", "above": "> "}[found.place]
    sign = FROM_LEVELS if found.source == "levels" and found.place == "within" else ""
    return f"{mark}{unit.found(found)}{sign}"


def found_cell(found: DetectableSeverity | None, unit: SeverityUnit) -> Cell:
    """The same as a cell; its value is missing where nothing is found."""
    value = None if found is None or found.value is None else unit.value(found.value)
    return Cell(found_text(found, unit), value=value)


def found_sentence(found: DetectableSeverity | None, unit: SeverityUnit) -> str:
    """The same in a sentence: ``finds 0.012 L/min``, ``detects no leak up to 1 L/min``."""
    if found is None:
        return "cannot be judged"
    number = f"{unit.found(found)} {unit.name}".rstrip()
    words = {"below": f"finds {number} or less", "within": f"finds {number}"}
    return words.get(found.place, f"detects no leak up to {number}") + unit.which_flow(unit.found(found))


def rate_text(rate: Rate | None, *, is_counted: bool = False) -> str:
    """A rate in percent with its interval; ``3 of 20`` where the records are too few for a rate."""
    if rate is None or not rate.total:
        return HOLE
    if is_counted:
        return f"{rate.count} of {rate.total}"
    return f"{percent(rate.value)} ({percent(rate.low)}–{percent(rate.high)})"


def rate_cell(judgement: Judgement, population: Population, *, is_strong: bool = False) -> Cell:
    """The rate of alarms of a population that is judged; marked with ! where it is too large."""
    rate = judgement.false_alarms.get(population)
    text = rate_text(rate, is_counted=population in judgement.counted)
    value = None if rate is None or math.isnan(rate.value) else 100.0 * rate.value
    return Cell(text, is_strong, value, mark="!")


def percent(share: float) -> str:
    """A share in percent: two digits below 10 %, whole numbers above."""
    value = 100.0 * share
    return f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def false_alarms_in_words(rate: float) -> str:
    """``one false alarm in a hundred``, or the rate in percent."""
    return _IN_WORDS.get(rate, f"a false-alarm rate of {100.0 * rate:.3g} %")


def probability_in_words(probability: float) -> str:
    """``nine times in ten``, or the probability in percent."""
    return "nine times in ten" if probability == 0.9 else f"in {100.0 * probability:.3g} % of all cases"


def cost_cell(judgement: Judgement) -> Cell:
    """CPU time per record [ms]."""
    cost = judgement.scored.cost
    return Cell(HOLE) if cost is None else Cell(two_digits(1e3 * cost), value=1e3 * cost)
