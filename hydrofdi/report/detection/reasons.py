"""Why less is found than was asked for, and what to change in the study."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from hydrofdi.evaluation.populations import Kind
from hydrofdi.report.detection.selection import best_of_sensors, best_with_sensors, of_sensors
from hydrofdi.report.detection.wording import sensors_in_words, severity_unit, symbols
from hydrofdi.report.wording import joined
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Detection, Judgement


def why_nothing(detection: Detection) -> str:
    """Why no severity is stated by a score that keeps its false-alarm rate, and what to change."""
    best, unit = best_of_sensors(detection), severity_unit(detection)
    if best:
        bound = unit.found(best[0].smallest["q90_95"])
        return f"no {unit.quantity} up to {bound} {unit.name}".rstrip() + " with any score"
    if not any(judgement.threshold for judgement in detection.judgements):
        return missing_thresholds(detection) or "no score has a threshold"
    if not detection.records.chosen(Kind.FAULT, is_fit=False):
        return "no leaking record is tested; set study.faults"
    if any(judgement.keeps_its_rate for judgement in detection.judgements):
        refusals = [each for judgement in detection.judgements for each in judgement.refusals]
        return refusals[0] if refusals else f"no {unit.quantity} can be stated"
    return why_unsure(detection)


def why_unsure(detection: Detection) -> str:
    """Why no score is known to keep its false-alarm rate, and what to change."""
    if all(judgement.keeps_its_rate is False for judgement in detection.judgements):
        names = dict.fromkeys(name for each in detection.judgements for name in exceeded_in(each))
        return (
            f"every score exceeds its false-alarm rate (in {joined([repr(name) for name in names])}); if"
            " these conditions are normal, let study.population include them"
        )
    return _too_few_to_know(detection)


def exceeded_in(judgement: Judgement) -> list[str]:
    """Names of the healthy test populations and shifts in which a score exceeds its false-alarm rate."""
    return [each.name for each in judgement.exceeded if each.kind is not Kind.CONFUSION]


def _too_few_to_know(detection: Detection) -> str:
    """Which records without a fault are too few for a rate of false alarms, and how many are needed."""
    few = {
        population.name: judgement.false_alarms[population].total
        for judgement in detection.judgements
        for population in judgement.counted
        if population.kind in (Kind.HEALTHY, Kind.SHIFT) and population in judgement.false_alarms
    }
    needed = f"{counted(detection.rules.records_for_false_alarms, 'record')} of each are needed"
    if not few:
        return f"no healthy test records show a false-alarm rate; {needed}"
    there = joined([f"{total:,} of '{name}'" for name, total in few.items()])
    return f"there are too few fault-free records to state a false-alarm rate: {there}; {needed}"


def missing_thresholds(detection: Detection) -> str:
    """How many scores have no threshold, why, and what to change; empty if all have one."""
    judgements, rules, records = detection.judgements, detection.rules, detection.records
    lacking = [each for each in judgements if each.threshold is None]
    if not lacking:
        return ""
    who = "no score has a" if len(lacking) == len(judgements) else f"{_share(lacking, judgements)} no"
    n_fit = sum(records.rows(each).size for each in records.chosen(Kind.HEALTHY, is_fit=True))
    needed = max(rules.records_for_threshold(each.direction) for each in lacking)
    if needed <= n_fit:
        reasons = dict.fromkeys(each.refusals[0] for each in lacking if each.refusals)
        return f"{who} threshold{': ' if reasons else ''}{'; '.join(reasons)}"
    return (
        f"{who} threshold for {100.0 * rules.false_alarm_rate:g} % false alarms: {n_fit:,} healthy records"
        f" set it, {needed:,} are needed; set study.healthy.fit to {needed}{_and_test(detection)}"
    )


def _and_test(detection: Detection) -> str:
    """How many healthy test records a measured false-alarm rate needs; empty if there are enough."""
    records, needed = detection.records, detection.rules.records_for_false_alarms
    n_test = sum(records.rows(each).size for each in records.chosen(Kind.HEALTHY, is_fit=False))
    return (
        f", and study.healthy.test to {needed} ({n_test:,} now) to measure the rate"
        if n_test < needed
        else ""
    )


def _share(some: Sequence[Judgement], judgements: Sequence[Judgement]) -> str:
    return f"{len(some)} of {counted(len(judgements), 'score')} {'has' if len(some) == 1 else 'have'}"


def unfound(detection: Detection) -> Iterator[str]:
    """A sentence on the sets of sensors with which nothing, or no smaller fault, is found."""
    unit, best = severity_unit(detection), best_with_sensors(detection)
    idle: dict[str, list[str]] = defaultdict(list)
    for sensors, scores in of_sensors(detection).items():
        found = best.get(sensors)
        if found is not None and found not in scores and found.smallest["q90_95"].value is not None:
            more = [symbol for symbol in symbols(scores[0]) if symbol not in symbols(found)]
            idle[joined(symbols(found))].append(joined(more))
            continue
        judged = [each for each in scores if "q90_95" in each.smallest and each.scored.channels]
        able = [each.smallest["q90_95"] for each in judged if each.keeps_its_rate is not False]
        if not judged or any(bound.value is not None for bound in able):
            continue
        lead = f"With {sensors_in_words(judged[0])}, "
        if not able:
            yield f"{lead}every score exceeds its false-alarm rate."
            continue
        keeping = "" if len(able) == len(judged) else " that keeps to its false-alarm rate"
        yield f"{lead}no score{keeping} finds anything up to {unit.found(able[0])} {unit.name}".rstrip() + "."
    for known, others in idle.items():
        yield f"Knowing {' or '.join(others)} as well does not help {known}."
