"""Which of many detectors a reader sees first."""

from __future__ import annotations

import re

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.studies.judgement import Detection, Judgement, Level

_WAVELET_RULES = re.compile(r"dwt\.d[23]|largest_change\b.*")
"""The RMS of d2 or d3 of P1, and the largest change of the details."""


def best_with_sensors(detection: Detection) -> dict[frozenset[str], Judgement]:
    """Each set of sensors → the best detector that keeps its false-alarm rate and needs no more than these.

    Sets with which nothing is known to keep its rate are left out; the set with the best detector is first.
    """
    judged = detection.judgements
    able = [each for each in judged if each.keeps_its_rate and each.smallest.get("q90_95") is not None]
    best = {
        sensors: each
        for each in reversed(able)
        for sensors in of_sensors(detection)
        if sensors == frozenset(each.scored.channels)
        or frozenset() < frozenset(each.scored.channels) < sensors
    }
    return dict(sorted(best.items(), key=lambda item: able.index(item[1])))


def of_sensors(detection: Detection) -> dict[frozenset[str], list[Judgement]]:
    """Each set of sensors → its scores; sets and scores in the order of the ranking."""
    scores: dict[frozenset[str], list[Judgement]] = {}
    for judgement in detection.judgements:
        scores.setdefault(frozenset(judgement.scored.channels), []).append(judgement)
    return scores


def first_of_sensors(detection: Detection) -> tuple[Judgement, ...]:
    """The best score with no more than each set of sensors, whether or not its false alarms are known.

    Those that are known to keep their false-alarm rate and have a q90/95 come first.
    """
    others = {sensors: scores[0] for sensors, scores in of_sensors(detection).items()}
    best = (others | best_with_sensors(detection)).values()
    return tuple(each for each in detection.judgements if each in best)


def answers(detection: Detection) -> tuple[Judgement, ...]:
    """The best detectors that find a fault, and a smaller one than others with fewer sensors; best first."""
    best = distinct(*best_with_sensors(detection).values())
    able = [each for each in best if each.smallest["q90_95"].value is not None]
    return tuple(each for each in able if not each.scored.channels or each.scored.name in detection.pareto)


def wavelet_rules(detection: Detection) -> tuple[Judgement, ...]:
    """The RMS of one wavelet detail, and the largest change of the details; shown for comparison."""
    return tuple(each for each in detection.judgements if _WAVELET_RULES.fullmatch(each.scored.name))


def foremost(detection: Detection, most: int) -> tuple[Judgement, ...]:
    """The best of each set of sensors, then the wavelet rules, then the next best; at most so many.

    Sets of sensors with which nothing is found come after the wavelet rules.
    """
    named = wavelet_rules(detection)
    best = distinct(*best_with_sensors(detection).values())
    best = tuple(sorted(best, key=lambda each: each.smallest["q90_95"].value is None))
    room = max(most - len(named), 1)
    chosen = distinct(*best[:room], *named, *best[room:], *detection.judgements)
    first = {each.scored.name for each in chosen[:most]}
    return tuple(each for each in detection.judgements if each.scored.name in first)


def distinct(*judgements: Judgement) -> tuple[Judgement, ...]:
    """Each score once, where it comes first."""
    by_name: dict[str, Judgement] = {}
    for judgement in judgements:
        by_name.setdefault(judgement.scored.name, judgement)
    return tuple(by_name.values())


def tested(detection: Detection, *kinds: Kind) -> tuple[Population, ...]:
    """Populations of these kinds whose false alarms are judged, in the order of the study."""
    judged = {population for judgement in detection.judgements for population in judgement.false_alarms}
    return tuple(each for each in detection.records.populations if each.kind in kinds and each in judged)


def chosen_levels(detection: Detection, most: int = 3) -> tuple[Population, ...]:
    """Faulty test populations, spread evenly over those that there are."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if len(levels) <= most:
        return levels
    places = [round((place + 1) * (len(levels) - 1) / (most + 1)) for place in range(most)]
    return tuple(levels[place] for place in dict.fromkeys(places))


def level_of(judgement: Judgement, population: Population) -> Level | None:
    """What is stated of a faulty population."""
    return next((level for level in judgement.levels if level.population == population), None)
