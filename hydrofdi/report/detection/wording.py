"""Severities, rates and sensors as text in a report."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hydrofdi.evaluation.pod.tally import DetectableSeverity
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.records import Channel
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.charts import RunLengths
from hydrofdi.studies.judgement import Detection, Judgement
from hydrofdi.units import convert

FROM_LEVELS = "°"
"""Marks what comes from the tested levels alone."""

_IN_WORDS = {0.1: "ten", 0.01: "a hundred", 0.001: "a thousand"}


@dataclass(frozen=True)
class SeverityUnit:
    """The unit in which a person reads the severities of a study.

    Attributes
    ----------
    name : str
        Such as ``L/min``.
    quantity : str
        What is measured in it.
    key, suffix : str
        Start and end of the keys of plain data.
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

    @property
    def bracket(self) -> str:
        """The unit at the end of a heading."""
        return f" [{self.name}]" if self.name else ""

    def value(self, severity: float) -> float:
        """A severity in SI, in this unit."""
        return convert(severity, self.name) if self.name == "L/min" else severity

    def text(self, severity: float) -> str:
        """A severity with three digits and its unit."""
        return f"{self.value(severity):.3g} {self.name}".rstrip()

    def found(self, found: DetectableSeverity | None, scale: float = 1.0) -> str:
        """What is found, such as ``0.012``, ``≤ 0.01`` (the smallest tested) or ``0.02°`` (from the levels).

        ``> 1`` is not found up to the largest nominal severity.
        """
        if found is None:
            return HOLE
        is_above = found.place == "above"
        severity = min(found.severity, self.largest) if is_above else found.severity
        sign = FROM_LEVELS if found.source == "levels" and found.place == "within" else ""
        mark = {"below": "≤ ", "above": "> "}.get(found.place, "")
        return f"{mark}{two_digits(float(two_digits(self.value(severity))) * scale)}{sign}"


def severity_unit(study: Detection | RunLengths) -> SeverityUnit:
    """L/min for leakage flows; every other severity keeps its unit."""
    records = study.records
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
    return [symbol(channel) for channel in judgement.scored.channels]


def symbol(channel: str) -> str:
    """The symbol of a channel; the name of another sensor."""
    return Channel(channel).symbol if channel in list(Channel) else channel


def rate_text(judgement: Judgement, population: Population) -> str:
    """Alarms in percent with their interval; ``3 of 20`` where the records are too few for a rate."""
    rate = judgement.false_alarms.get(population)
    if rate is None or not rate.total:
        return HOLE
    if population in judgement.counted:
        return f"{rate.count} of {rate.total}"
    return f"{percent(rate.value)} ({percent(rate.low)}–{percent(rate.high)})"


def percent(share: float) -> str:
    """A share in percent: two digits below 10 %, whole numbers above."""
    value = 100.0 * share
    return f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def false_alarms_in_words(rate: float) -> str:
    """``one false alarm in a hundred``, or the rate in percent."""
    return (
        f"one false alarm in {_IN_WORDS[rate]}"
        if rate in _IN_WORDS
        else f"a false-alarm rate of {100.0 * rate:.3g} %"
    )


def probability_in_words(probability: float) -> str:
    """``nine times in ten``, or the probability in percent."""
    return "nine times in ten" if probability == 0.9 else f"in {100.0 * probability:.3g} % of all cases"
