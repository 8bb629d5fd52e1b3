"""Severities, rates and sensors as text in a report, and which of many detectors a reader sees first."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from hydrofdi.evaluation.pod import DetectableSeverity
from hydrofdi.evaluation.rates import Rate
from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.records import Channel
from hydrofdi.settings.messages import HOLE, convert, two_digits
from hydrofdi.studies.records import Detection, Judgement, Outcome

FROM_LEVELS = "°"
"""Marks what comes from the tested levels alone."""

_IN_WORDS = {0.1: "ten", 0.01: "a hundred", 0.001: "a thousand"}


@dataclass(frozen=True)
class SeverityUnit:
    """The unit in which a person reads the severities of a study, such as L/min of leakage.

    `key`, `suffix`: start and end of the keys of plain data. `largest`: largest severity tested [SI].
    `per_mean_flow`: flow of the same leak at 8 MPa, per mean flow in the record; NaN if unknown.
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


def severity_unit(detection: Detection) -> SeverityUnit:
    """L/min for leakage flows; every other severity keeps its unit."""
    records = detection.records
    largest = max((each.severity for each in records.chosen(Kind.FAULT, is_fit=False)), default=math.inf)
    if (own := records.severity_unit) == "m^3/s":
        keys = ("leakage_L_per_min", "_L_per_min")
        return SeverityUnit("L/min", "leakage", *keys, largest, records.per_mean_flow)
    return SeverityUnit("" if own == "1" else own, "severity", "severity", "", largest)


def sensors(judgement: Judgement) -> str:
    """What a score needs of a machine, such as ``P1 P2 x u``; a hole if it does not say so."""
    return " ".join(symbols(judgement)) or HOLE


def symbols(judgement: Judgement) -> list[str]:
    """The symbols of the sensors that a score needs, such as ``P1``; other sensors by their names."""
    known = {channel.value: channel.symbol for channel in Channel}
    return [known.get(channel, channel) for channel in judgement.scored.channels]


def rate_text(outcome: Outcome[Rate | None] | None, *, with_interval: bool = True) -> str:
    """Alarms in percent with their interval; ``3 of 20`` where the records are too few for a rate."""
    if outcome is None or outcome.found is None or not (rate := outcome.found).total:
        return HOLE
    if outcome.is_counted:
        return f"{rate.count} of {rate.total}"
    return percent(rate.value) + f" ({percent(rate.low)}–{percent(rate.high)})" * with_interval


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


_WAVELET_RULES = re.compile(r"dwt\.d[23]|largest_change\b.*")
"""The RMS of d2 or d3 of P1, and the largest change of the details."""


def best_with_sensors(detection: Detection) -> dict[frozenset[str], Judgement]:
    """Each set of sensors → the best detector that keeps its false-alarm rate and needs no more than these.

    Sets with which nothing is known to keep its rate are left out; the set with the best detector is first.
    """
    judged = detection.judgements
    able = [each for each in judged if each.keeps_its_rate and each.bound is not None]
    best = {
        sensors: each
        for each in reversed(able)
        for sensors in dict.fromkeys(frozenset(judgement.scored.channels) for judgement in judged)
        if sensors == frozenset(each.scored.channels)
        or frozenset() < frozenset(each.scored.channels) < sensors
    }
    return dict(sorted(best.items(), key=lambda item: able.index(item[1])))


def answers(detection: Detection) -> tuple[Judgement, ...]:
    """The best detectors that find a fault, and a smaller one than others with fewer sensors; best first."""
    able = (each for each in dict.fromkeys(best_with_sensors(detection).values()) if each.finds)
    return tuple(each for each in able if not each.scored.channels or each.name in detection.pareto)


def wavelet_rules(detection: Detection) -> tuple[Judgement, ...]:
    """The RMS of one wavelet detail, and the largest change of the details; shown for comparison."""
    return tuple(each for each in detection.judgements if _WAVELET_RULES.fullmatch(each.name))


def foremost(detection: Detection, most: int) -> tuple[Judgement, ...]:
    """The best of each set of sensors, then the wavelet rules, then the next best; at most so many.

    Sets of sensors with which nothing is found come after the wavelet rules.
    """
    named = wavelet_rules(detection)
    best = sorted(dict.fromkeys(best_with_sensors(detection).values()), key=lambda each: not each.finds)
    room = max(most - len(named), 1)
    chosen = [*dict.fromkeys((*best[:room], *named, *best[room:], *detection.judgements))][:most]
    return tuple(judgement for judgement in detection.judgements if judgement in chosen)


def tested(detection: Detection, *kinds: Kind) -> tuple[Population, ...]:
    """Populations of these kinds whose false alarms are judged, in the order of the study."""
    judged = {population for judgement in detection.judgements for population in judgement.false_alarms}
    return tuple(each for each in detection.records.populations if each.kind in kinds and each in judged)


def chosen_levels(detection: Detection, most: int = 3) -> tuple[Population, ...]:
    """Faulty test populations, spread evenly over those that there are."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if len(levels) <= most:
        return levels
    positions = [round((index + 1) * (len(levels) - 1) / (most + 1)) for index in range(most)]
    return tuple(levels[position] for position in dict.fromkeys(positions))
