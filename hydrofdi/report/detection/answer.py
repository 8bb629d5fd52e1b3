"""The answer in plain English, and the table that it is taken from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hydrofdi.evaluation.populations import Kind
from hydrofdi.report.detection.ranking import ranking_note, ranking_sheet
from hydrofdi.report.detection.reasons import (
    exceeded_in,
    missing_thresholds,
    unfound,
    why_nothing,
    why_unsure,
)
from hydrofdi.report.detection.selection import (
    answers,
    best_of_sensors,
    distinct,
    first_of_sensors,
    tested,
    wavelet_rules,
)
from hydrofdi.report.detection.wording import (
    false_alarms_in_words,
    found_sentence,
    percent,
    probability_in_words,
    sensors_in_words,
    severity_unit,
)
from hydrofdi.report.document import Block
from hydrofdi.report.wording import capitalized, joined
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Detection, Judgement

_MOST = 6
"""Sets of sensors that the answer names."""

_TITLE = "The best with each set of sensors, and wavelet rules"

_KINDS = {
    (Kind.HEALTHY, True): "healthy to set the thresholds",
    (Kind.HEALTHY, False): "healthy to test them",
    (Kind.FAULT, True): "leaking to train on",
    (Kind.FAULT, False): "leaking to detect",
    (Kind.SHIFT, False): "in shifts",
    (Kind.CONFUSION, False): "with another fault",
    (Kind.ALONE, False): "with a single nuisance",
    (Kind.SOBOL, False): "of a Sobol design",
}


def answer_block(detection: Detection, *, is_complete: bool = True, remark: str = "") -> Block:
    """What is found with which sensors, from how many records; while runs are missing, the table alone."""
    rules = wavelet_rules(detection)
    shown = distinct(*first_of_sensors(detection), *rules)
    sheet = ranking_sheet(detection, shown, "best", _TITLE)
    if not is_complete:
        return Block("answer", "Records so far", (_records_sentence(detection),), (sheet,))
    answer, lacking = answer_sentence(detection), missing_thresholds(detection)
    lacking = f"{capitalized(lacking)}." if lacking and lacking not in answer else ""
    sentences = (
        answer, _beyond_nominal(detection), *unfound(detection), remark, lacking,
        _comparison(detection, rules), _counts(detection), _among_many(detection),
    )  # fmt: skip
    return Block(
        "answer",
        "What is found",
        tuple(filter(None, sentences)),
        (replace(sheet, note=ranking_note(detection)),),
        ("answer", "ranking") if answers(detection) else ("ranking",),
    )


def answer_sentence(detection: Detection) -> str:
    """The question, answered for each set of sensors; the best first."""
    unit, best = severity_unit(detection), best_of_sensors(detection)
    found = answers(detection)[:_MOST]
    asked = detection.rules
    terms = (
        f"{probability_in_words(asked.probability)} ({100.0 * asked.confidence:g} % confidence)"
        f" at thresholds set for {false_alarms_in_words(asked.false_alarm_rate)}"
    )
    unsure = [each for each in detection.judgements if _has_bound(each)]
    if not found and unsure and not best:
        first = f"{_with(unsure[0])} {found_sentence(unsure[0].smallest['q90_95'], unit)}"
        return f"{capitalized(first)} {terms}, but {why_unsure(detection)}."
    if not found:
        keeping = " that kept to its false-alarm rate" if unsure else ""
        return f"Nothing is found {terms}: {why_nothing(detection)}{keeping}."
    parts = [
        f"{_with(each)} {found_sentence(each.smallest['q90_95'], unit)}"
        f"{' ' + terms if first else ''}"
        f"{_measured_alarms(detection, each)}"
        for first, each in zip([True] + [False] * len(found), found, strict=False)
    ]
    return f"{capitalized('; '.join(parts))}."


def _beyond_nominal(detection: Detection) -> str:
    """Where severities come from that are above the largest nominal one; empty if none is."""
    unit, records = severity_unit(detection), detection.records
    bounds = [each.smallest["q90_95"].value or 0.0 for each in answers(detection)[:_MOST]]
    levels = records.chosen(Kind.FAULT, is_fit=False)
    if not levels or max(bounds, default=0.0) <= unit.largest:
        return ""
    largest = max(float(np.nanmax(records.severity[records.rows(level)])) for level in levels)
    return (
        f"Records of the largest level, {unit.text(unit.largest)}, have a true mean {unit.quantity} of up to"
        f" {unit.text(largest)}, because drawn parameters change it."
    )


def _has_bound(judgement: Judgement) -> bool:
    """Whether a tested severity is found, whatever its false alarms are."""
    bound = judgement.smallest.get("q90_95")
    return bound is not None and bound.value is not None


def _measured_alarms(detection: Detection, judgement: Judgement) -> str:
    """The measured rate of false alarms with its interval, and whether that lies above the rate set."""
    for population in tested(detection, Kind.HEALTHY)[:1]:
        rate = judgement.false_alarms.get(population)
        if rate is not None and rate.total and population not in judgement.counted:
            asked = detection.rules.false_alarm_rate
            more = f", more than the {100.0 * asked:g} % set" if rate.low > asked else ""
            interval = f"{percent(rate.low)}–{percent(rate.high)} %"
            return f" (measured false alarms {percent(rate.value)} %, {interval}{more})"
    return ""


def _with(judgement: Judgement) -> str:
    if not judgement.scored.channels:
        return judgement.scored.name
    return f"with {sensors_in_words(judgement)}, {judgement.scored.name}"


def _comparison(detection: Detection, rules: Sequence[Judgement]) -> str:
    """What the RMS of one detail and the largest change of the details find."""
    unit = severity_unit(detection)
    found = [
        f"{each.scored.name} {found_sentence(each.smallest.get('q90_95'), unit)}{_exceeds(each)}"
        for each in rules
    ]
    return f"For comparison, the usual wavelet rules: {'; '.join(found)}." if found else ""


def _exceeds(judgement: Judgement) -> str:
    names = joined([f"'{name}'" for name in exceeded_in(judgement)])
    return f" (and exceeds its false-alarm rate in {names})" if names else ""


def _among_many(detection: Detection) -> str:
    """What the best is worth where it was chosen among many."""
    if not detection.judgements:
        return ""
    first, n_tried = detection.judgements[0], len(detection.judgements)
    found = first.smallest.get("q90_95_of_all")
    if found is None or n_tried == 1 or not first.keeps_its_rate:
        return ""
    return (
        f"The best was chosen among {n_tried}: with a confidence that holds for all of them together,"
        f" {first.scored.name} {found_sentence(found, severity_unit(detection))}."
    )


def _records_sentence(detection: Detection) -> str:
    records = detection.records
    per_kind: Counter[tuple[Kind, bool]] = Counter()
    for number, population in enumerate(records.populations):
        per_kind[population.kind, population.is_fit] += int((records.of_record == number).sum())
    parts = [f"{per_kind[key]:,} {words}" for key, words in _KINDS.items() if per_kind[key]]
    return f"From {counted(records.of_record.size, 'record')}{': ' if parts else ''}{joined(parts)}."


def _counts(detection: Detection) -> str:
    judgements = detection.judgements
    n_kept = sum(judgement.keeps_its_rate is True for judgement in judgements)
    n_found = sum(judgement.keeps_its_rate is True and _has_bound(judgement) for judgement in judgements)
    return (
        f"{_records_sentence(detection)} {counted(len(judgements), 'score')} were tried;"
        f" {n_kept} kept to the false-alarm rate as far as the data can show (healthy test records and"
        f" shifts); {n_found} of these {'detects' if n_found == 1 else 'detect'} at least one of the tested"
        " leaks."
    )
