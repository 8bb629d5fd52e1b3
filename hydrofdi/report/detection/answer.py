"""What is found with which sensors and why not more, and the tables of all scores behind it."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.report.detection import wording
from hydrofdi.report.document import Block
from hydrofdi.report.runs import capitalized, joined
from hydrofdi.settings.messages import HOLE, counted, two_digits
from hydrofdi.studies.records import Detection, Judgement
from hydrofdi.tables.table import Column, Table

_MOST, _MOST_REMARKS = 5, 30
"""Rows of the table of the answer, and remarks on scores."""

_P_VALUE = re.compile(r" \(p = [^)]*\)")

_TESTING = {Kind.HEALTHY: "healthy", Kind.FAULT: "leaking", Kind.SHIFT: "shifted"}


def answer_block(
    detection: Detection, *, is_complete: bool = True, without_noise: tuple[str, ...] = ()
) -> Block:
    """What is found with which sensors, the sentence last; while runs are missing, the table alone."""
    table, rests = _answer_table(detection), " ".join(_rests_on(detection, without_noise))
    if not is_complete:
        return Block("answer", "Records so far", (rests,), (table,))
    said = filter(None, (rests, answer_sentence(detection)))
    figures = ("answer",) if wording.answers(detection) else ()
    return Block("answer", "What is found", tuple(said), (table,), figures)


def _answer_table(detection: Detection) -> Table:
    """The best with each set of sensors, and the best wavelet rule."""
    unit, healthy = wording.severity_unit(detection), wording.tested(detection, Kind.HEALTHY)[:1]
    rules = wording.wavelet_rules(detection)[:1]
    shown = wording.distinct(*wording.first_of_sensors(detection)[: _MOST - len(rules)], *rules)
    bounds = [each.smallest.get("q90_95") for each in shown]
    has_both = not math.isnan(unit.per_mean_flow)
    columns = (
        Column("Sensors", list(map(wording.sensors, shown)), is_text=True),
        Column("Score", [each.scored.name + KEEPING[each.keeps_its_rate] for each in shown], is_text=True),
        Column(
            f"{unit.quantity.capitalize()}{unit.bracket}",
            sizes := list(map(unit.found, bounds)),
        ),
        *([Column(f"At 8 MPa{unit.bracket}", [unit.found(each, unit.per_mean_flow) for each in bounds])]
          if has_both else []),
        *(Column("Alarms [%]", [wording.rate_text(each, population) for each in shown])
          for population in healthy),
    )  # fmt: skip
    signs = {
        "≤": "at most the smallest tested",
        ">": "not found up to the largest tested",
        wording.FROM_LEVELS: "from the tested levels, without a curve",
        "!": "more false alarms than set",
        "?": "too few records to tell its false alarms",
    }
    texts = "".join([*sizes, *(KEEPING[each.keeps_its_rate] for each in shown)])
    note = ["Alarms: of healthy records", *(f"{sign} {signs[sign]}" for sign in signs if sign in texts)]
    return Table(columns, key="best", notes=("; ".join(note) + ".",))


def _rests_on(detection: Detection, without_noise: tuple[str, ...]) -> Iterator[str]:
    """Records and scores behind the answer."""
    records, judgements = detection.records, detection.judgements
    sizes: Counter[tuple[Kind, bool]] = Counter()
    for population in records.populations:
        sizes[population.kind, population.is_fit] += records.rows(population).size
    testing = [f"{sizes[kind, False]:,} {word}" for kind, word in _TESTING.items() if sizes[kind, False]]
    yield (
        f"{sizes[Kind.HEALTHY, True]:,} healthy records set the thresholds; {joined(testing) or 'no'} records"
        " test them."
    )
    n_kept = sum(judgement.keeps_its_rate is True for judgement in judgements)
    n_open = sum(judgement.keeps_its_rate is None for judgement in judgements)
    undecided = f"; {n_open} are undecided, as too few records test them" if n_open else ""
    yield f"{n_kept} of {counted(len(judgements), 'score')} kept to the false-alarm rate{undecided}."
    of_all = judgements[0].smallest.get("q90_95_of_all") if judgements else None
    if of_all is not None and len(judgements) > 1 and judgements[0].keeps_its_rate:
        unit = wording.severity_unit(detection)
        found = f"{unit.found(of_all)} {unit.name}"
        yield f"Allowing for the choice of the best of {len(judgements)}: {found}."
    if without_noise:
        yield f"{joined(without_noise)} {'are' if len(without_noise) > 1 else 'is'} simulated without noise."


def answer_sentence(detection: Detection) -> str:
    """The best that is found, or why nothing is."""
    unit, asked, best = (
        wording.severity_unit(detection),
        detection.rules,
        wording.best_with_sensors(detection),
    )
    terms = (
        f"{wording.probability_in_words(asked.probability)} ({100.0 * asked.confidence:g} % confidence)"
        f" at {wording.false_alarms_in_words(asked.false_alarm_rate)}"
    )
    found = (*wording.answers(detection), *(() if best else filter(wording.finds, detection.judgements)))
    if not found:
        largest = [unit.found(each.smallest["q90_95"]).removeprefix("> ") for each in best.values()][:1]
        none = [f"no {unit.quantity} up to {each} {unit.name}".rstrip() for each in largest]
        refusals = Counter(text for each in detection.judgements for text in each.refusals).most_common(1)
        why = (*none, *(text for text, _ in refusals), "no leaking record is tested")[0]
        return f"Nothing is found {terms}: {why}."
    bound, scored = found[0].smallest["q90_95"], found[0].scored
    number = unit.found(bound).removeprefix("≤ ").removesuffix(wording.FROM_LEVELS)
    size = f"{number} {unit.name}".rstrip() + (" or less" if bound.place == "below" else "")
    if not math.isnan(unit.per_mean_flow):
        at_reference = (
            unit.found(bound, unit.per_mean_flow).removeprefix("≤ ").removesuffix(wording.FROM_LEVELS)
        )
        size += f" in this motion ({at_reference} at 8 MPa)"
    plain = scored.indicator.replace("_", " ")
    name = f"the {plain} ({scored.name})" if plain not in ("", scored.indicator) else scored.name
    needs = f"with {joined(wording.symbols(found[0]))}, " if scored.channels else ""
    reservations = {
        True: "",
        None: f", but {counted(asked.records_for_false_alarms, 'record')} of each fault-free test population"
        " are needed to know its false-alarm rate",
        False: ", but exceeds its false-alarm rate; let study.population include the shifts that are normal",
    }
    return f"{capitalized(f'{needs}{name} finds {size} {terms}{reservations[found[0].keeps_its_rate]}')}."


def remarks_with_counts(detection: Detection) -> tuple[str, ...]:
    """Remarks on all numbers, then what is not stated or remarked of some scores, with their number.

    A score without any number has only its note.
    """
    n_score = len(detection.judgements)
    notes, others = Counter[str](), Counter[str]()
    for judgement in detection.judgements:
        scored = judgement.scored
        if np.isfinite(scored.values).any():
            texts = (*judgement.refusals, *judgement.remarks, *filter(None, [scored.note]))
            others.update([*dict.fromkeys(_P_VALUE.sub("", text) for text in texts)])
        else:
            notes[scored.note] += 1
    told = (*notes.most_common(), *others.most_common(_MOST_REMARKS))
    return (
        *detection.remarks,
        *(f"{text} ({n} of {counted(n_score, 'score')})" if n < n_score else text for text, n in told),
    )


def remarks_block(detection: Detection) -> Block | None:
    """What could not be stated, and remarks on what is stated; None if there are none."""
    said = [f"{capitalized(text).rstrip('.')}." for text in remarks_with_counts(detection)]
    return Block("caveats", "Limitations and remarks", tuple(said)) if said else None


KEEPING = {True: "", None: " ?", False: " !"}
"""Whether a score keeps its false-alarm rate → mark of its name."""

_MARKS = {"rising": "↑", "falling": "↓", "both": "↕"}
_MOST_ALARMS, _MOST_LEVELS = 20, 12


def ranking_block(detection: Detection) -> Block:
    """Every score that was tried."""
    unit, judgements, levels = (
        wording.severity_unit(detection),
        detection.judgements,
        wording.chosen_levels(detection, 1),
    )
    areas = [[wording.level_of(judgement, level) for judgement in judgements] for level in levels]
    costs = [judgement.scored.cost for judgement in judgements]
    columns = (
        Column(
            "Score",
            [f"{e.scored.name} {_MARKS[e.direction]}{KEEPING[e.keeps_its_rate]}" for e in judgements],
            is_text=True,
        ),
        Column("Sensors", list(map(wording.sensors, judgements)), is_text=True),
        *(
            Column(
                f"{title}{unit.bracket}",
                [unit.found(judgement.smallest.get(name)) for judgement in judgements],
                strong=_places(judgement.scored.name in detection.pareto for judgement in judgements)
                if name == "q90_95"
                else (),
            )
            for name, title in (("q90_95", "q90/95"), ("q90", "q90"), ("q50", "q50"))
        ),
        *(
            Column("False alarms [%]", [wording.rate_text(judgement, population) for judgement in judgements])
            for population in wording.tested(detection, Kind.HEALTHY)[:1]
        ),
        *(
            Column("AUC", [f"{each.area.value:.2f}" if each and each.area else HOLE for each in own])
            for own in areas
        ),
        Column("Cost [ms]", [HOLE if cost is None else two_digits(1e3 * cost) for cost in costs]),
    )
    order = (
        "Scores that do not exceed their false-alarm rate come first, by q90/95. Scores that exceed it (!) or"
        " have too few records to tell (?) follow. A bold q90/95 (in plain text *) is Pareto-optimal: no"
        " other score detects a smaller leak with the same or fewer sensors."
    )
    table = Table(columns, "All scores", "scores", tuple(_ranking_notes(detection)))
    return Block("ranking", "Ranking", (order,), (table,), ("ranking",))


def _ranking_notes(detection: Detection) -> Iterator[str]:
    asked, unit = detection.rules, wording.severity_unit(detection)
    confidence = f"{100.0 * asked.confidence:g} %"
    yield (
        f"q90/95: upper bound with {confidence} confidence on the {unit.quantity} found with"
        f" {100.0 * asked.probability:g} % probability; q90 and q50: estimates without confidence."
        f" ≤: at most the smallest tested; >: not found up to the largest tested; {wording.FROM_LEVELS}: read"
        " from the tested leaks, because no curve fitted (rounded up). False alarms: healthy test records at"
        f" thresholds for {100.0 * asked.false_alarm_rate:g} %. ↑, ↓, ↕: alarm if it rises, falls, or either."
    )
    for level in wording.chosen_levels(detection, 1):
        yield f"AUC: area under the ROC curve at {unit.text(level.severity)}."


def false_alarms_block(detection: Detection) -> Block | None:
    """Rates on the healthy test records, each shift and each confusion; None if nothing was tested."""
    shown = [each for each in wording.foremost(detection, _MOST_ALARMS) if each.threshold is not None]
    rules, total = detection.rules, len(detection.judgements)
    interval = f"In parentheses the {100.0 * rules.confidence:g} % interval (Clopper and Pearson)."
    left_out = f" {len(shown)} of {counted(total, 'score')}; CSV and JSON have all."
    notes = (interval + (left_out if len(shown) < total else ""),)
    tables = [
        Table((_names(shown), *(_alarms(shown, population) for population in populations)), title, key, notes)
        for key, title, kinds in (
            ("shifts", "Fresh healthy records and shifts", (Kind.HEALTHY, Kind.SHIFT)),
            ("confusions", "Other faults", (Kind.CONFUSION,)),
        )
        if (populations := wording.tested(detection, *kinds))
    ]
    sentence = (
        f"Thresholds are set for {100.0 * rules.false_alarm_rate:g} % on healthy fit records. Bold (in plain"
        f" text *): significantly more alarms than the threshold allows ({100.0 * rules.confidence:g} %"
        " confidence). A score without false alarms in a shift is of use only where it finds leaks as well."
    )
    figures = ("false_alarms", "densities")
    return Block("false-alarms", "False alarms", (sentence,), tuple(tables), figures) if tables else None


def _names(shown: Sequence[Judgement]) -> Column:
    return Column("Score", [each.scored.name for each in shown], is_text=True)


def _alarms(shown: Sequence[Judgement], population: Population) -> Column:
    is_strong = (population in each.exceeded for each in shown)
    texts = [wording.rate_text(each, population) for each in shown]
    return Column(f"{population.name} [%]", texts, strong=_places(is_strong))


def _places(are_strong: Iterator[bool]) -> tuple[int, ...]:
    return tuple(index for index, is_strong in enumerate(are_strong) if is_strong)


def levels_block(detection: Detection) -> Block | None:
    """Detections at each level by the foremost scores; None if no fault was tested."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if not levels:
        return None
    unit, least = wording.severity_unit(detection), detection.rules.probability
    shown = [each for each in wording.foremost(detection, _MOST_LEVELS) if each.threshold is not None]
    columns = [_names(shown)]
    for level in levels:
        rates = [(each, own.detected if (own := wording.level_of(each, level)) else None) for each in shown]
        texts = [
            HOLE
            if rate is None or not rate.total
            else f"{rate.count} of {rate.total}"
            if level in each.counted
            else wording.percent(rate.value)
            for each, rate in rates
        ]
        is_strong = (bool(rate and rate.value >= least and level not in each.counted) for each, rate in rates)
        columns.append(Column(f"{unit.value(level.severity):.3g}", texts, strong=_places(is_strong)))
    title = f"Detected [%] at each {unit.quantity}{unit.bracket}"
    note = f"Bold (in plain text *): {100.0 * least:g} % or more. All scores are in JSON and CSV."
    paragraph = (
        "Points are the tested levels, curves are fitted over the true severity of each record. "
        "Results come from the curve if it describes the points, otherwise only from the levels."
    )
    table = Table(tuple(columns), title, "levels", (note,))
    return Block("levels", "Probability of detection", (paragraph,), (table,), ("pod", "roc"))
