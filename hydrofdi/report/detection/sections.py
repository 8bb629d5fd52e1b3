"""The sections on a judged study: what is found, and the tables behind it."""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.machine import REFERENCE_DROP
from hydrofdi.config.values import shown_value, shown_values
from hydrofdi.evaluation.scores import NOTHING, Kind, Population, comparable
from hydrofdi.records import Channel
from hydrofdi.report.detection import wording
from hydrofdi.report.detection.record import chart_record, nuisances, run_length_lines
from hydrofdi.report.document import Block
from hydrofdi.report.runs import capitalized, joined
from hydrofdi.settings.messages import HOLE, counted, two_digits
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.studies.detecting import ERROR, estimated
from hydrofdi.studies.records import SOUND, Detection, Judgement, Nuisance
from hydrofdi.tables.table import Column, Table, group_breaks

_MOST, _MOST_REMARKS = 5, 30
"""Rows of the table of the answer, and remarks on scores."""

_P_VALUE = re.compile(r" \(p = [^)]*\)")

_SIGNS = (
    f"≤: at most the smallest tested; >: not found up to the largest tested; {wording.FROM_LEVELS}: from the"
    " tested levels, as no curve fits; !: more false alarms than set; ?: too few records to tell."
)

_SENSORS = {
    Channel.CHAMBER_1_PRESSURE: "pressure_1_sensor",
    Channel.CHAMBER_2_PRESSURE: "pressure_2_sensor",
    Channel.SUPPLY_PRESSURE: "supply_sensor",
    Channel.PISTON_POSITION: "position_sensor",
    Channel.PISTON_VELOCITY: "velocity_sensor",
    Channel.SPOOL_POSITION: "spool_sensor",
    Channel.OIL_TEMPERATURE: "temperature_sensor",
}

_TESTING = {Kind.HEALTHY: "healthy", Kind.FAULT: "leaking", Kind.SHIFT: "shifted"}


def answer_block(
    detection: Detection, experiment: ExperimentConfig | None = None, *, is_complete: bool = True
) -> Block:
    """What is found with which sensors, the sentence last; while runs are missing, the table alone."""
    tables, rests = (_answer_table(detection),), " ".join(_rests_on(detection, experiment))
    if not is_complete:
        return Block("answer", "Records so far", (rests,), tables, is_answer=True)
    figures = ("answer",) if wording.answers(detection) else ()
    said = (rests, answer_sentence(detection))
    return Block("answer", "What is found", said, tables, figures, is_answer=True)


def _answer_table(detection: Detection) -> Table:
    """The best with each set of sensors, and the best wavelet rule."""
    unit, rules = wording.severity_unit(detection), wording.wavelet_rules(detection)[:1]
    of_sensors = {frozenset(each.scored.channels): each for each in reversed(detection.judgements)}
    best = (of_sensors | wording.best_with_sensors(detection)).values()
    first = [judgement for judgement in detection.judgements if judgement in best]
    shown = [*dict.fromkeys((*first[: _MOST - len(rules)], *rules))]
    sizes = [unit.found(each.bound) for each in shown]
    columns = [
        Column("Sensors", list(map(wording.sensors, shown)), is_text=True),
        Column("Score", [each.name + KEEPING[each.keeps_its_rate] for each in shown], is_text=True),
        Column(f"{unit.quantity.capitalize()}{unit.bracket}", sizes),
    ]
    if not math.isnan(unit.per_mean_flow):
        at_reference = [unit.found(each.bound, unit.per_mean_flow) for each in shown]
        columns.append(Column(f"At 8 MPa{unit.bracket}", at_reference))
    healthy = wording.tested(detection, Kind.HEALTHY)[:1]
    columns += [_rates("Alarms [%]", shown, each) for each in healthy]
    return Table(tuple(columns), key="best", notes=(f"Alarms: of healthy records. {_SIGNS}",))


def _rests_on(detection: Detection, experiment: ExperimentConfig | None) -> Iterator[str]:
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
    kept = Counter(judgement.keeps_its_rate for judgement in judgements)
    undecided = f"; {kept[None]} are undecided, as too few records test them" if kept[None] else ""
    yield f"{kept[True]} of {counted(len(judgements), 'score')} kept to the false-alarm rate{undecided}."
    tests = [kept for chart in detection.charts for kept in chart.kept]
    if n_broken := tests.count(False):
        yield f"Charts raise more false alarms than set in {n_broken} of {len(tests)} tests of their limits."
    of_all = judgements[0].smallest.get("q90_95_of_all") if judgements else None
    if of_all is not None and len(judgements) > 1 and judgements[0].keeps_its_rate:
        unit = wording.severity_unit(detection)
        found = f"{unit.found(of_all)} {unit.name}"
        yield f"Allowing for the choice of the best of {len(judgements)}: {found}."
    if experiment and (perfect := without_noise(experiment, detection)):
        yield f"Simulated without noise: {joined(perfect)}."


def without_noise(experiment: ExperimentConfig, detection: Detection) -> list[str]:
    """Symbols of measured signals without noise that the best score with some set of sensors uses."""
    used = {name for each in wording.best_with_sensors(detection).values() for name in each.scored.channels}
    drawn = experiment.study.population.over if experiment.study else {}
    chosen = {**detection.records.design, **drawn}
    return [
        channel.symbol
        for channel, sensor in _SENSORS.items()
        if channel.value in used
        and not any(
            chosen.get(name, experiment.value(name))
            for name in (f"{sensor}.noise", f"{sensor}.noise_density")
        )
    ]


def answer_sentence(detection: Detection) -> str:
    """The best that is found, or why nothing is."""
    unit, asked = wording.severity_unit(detection), detection.rules
    best = wording.best_with_sensors(detection)
    terms = (
        f"{wording.probability_in_words(asked.probability)} ({100.0 * asked.confidence:g} % confidence)"
        f" at {wording.false_alarms_in_words(asked.false_alarm_rate)}"
    )
    able = wording.answers(detection) if best else (each for each in detection.judgements if each.finds)
    if (first := next(iter(able), None)) is None:
        largest = [unit.found(each.bound).removeprefix("> ") for each in best.values()][:1]
        none = [f"no {unit.quantity} up to {each} {unit.name}".rstrip() for each in largest]
        refusals = Counter(text for each in detection.judgements for text in each.refusals).most_common(1)
        why = (*none, *(text for text, _ in refusals), "no leaking record is tested")[0]
        return f"Nothing is found {terms}: {why}."
    mean, at_reference = (
        unit.found(first.bound, scale).removeprefix("≤ ").removesuffix(wording.FROM_LEVELS)
        for scale in (1.0, unit.per_mean_flow)
    )
    size = f"{mean} {unit.name}".rstrip()
    size += " or less" if first.bound and first.bound.place == "below" else ""
    if not math.isnan(unit.per_mean_flow):
        size += f" in this motion ({at_reference} at 8 MPa)"
    needs = f"with {joined(wording.symbols(first))}, " if first.scored.channels else ""
    reservations = {
        True: "",
        None: f", but {counted(asked.records_for_false_alarms, 'record')} of each fault-free test population"
        " are needed to know its false-alarm rate",
        False: ", but exceeds its false-alarm rate; let study.population include the shifts that are normal",
    }
    reservation = reservations[first.keeps_its_rate]
    return f"{capitalized(f'{needs}{first.name} finds {size} {terms}{reservation}')}."


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
    unit, judgements, asked = wording.severity_unit(detection), detection.judgements, detection.rules
    notes = [
        f"q90/95: upper bound with {100.0 * asked.confidence:g} % confidence on the {unit.quantity} found"
        f" with {100.0 * asked.probability:g} % probability; q90 and q50: estimates without confidence."
        f" {_SIGNS} False alarms: of healthy test records, at thresholds for"
        f" {100.0 * asked.false_alarm_rate:g} %. ↑, ↓, ↕: alarm if it rises, falls, or either."
    ]
    names = [f"{each.name} {_MARKS[each.direction]}{KEEPING[each.keeps_its_rate]}" for each in judgements]
    columns = [
        Column("Score", names, is_text=True),
        Column("Sensors", list(map(wording.sensors, judgements)), is_text=True),
    ]
    for name, title in (("q90_95", "q90/95"), ("q90", "q90"), ("q50", "q50")):
        texts = [unit.found(each.smallest.get(name)) for each in judgements]
        best = _places(name == "q90_95" and each.name in detection.pareto for each in judgements)
        columns.append(Column(f"{title}{unit.bracket}", texts, strong=best))
    healthy = wording.tested(detection, Kind.HEALTHY)[:1]
    columns += [_rates("False alarms [%]", judgements, each) for each in healthy]
    for level in wording.chosen_levels(detection, 1):
        own = [each.of(level) for each in judgements]
        areas = [f"{each.area.value:.2f}" if each and each.area else HOLE for each in own]
        columns.append(Column("AUC", areas))
        notes.append(f"AUC: area under the ROC curve at {unit.text(level.severity)}.")
    costs = [judgement.scored.cost for judgement in judgements]
    columns.append(Column("Cost [ms]", [HOLE if cost is None else two_digits(1e3 * cost) for cost in costs]))
    order = (
        "Scores that do not exceed their false-alarm rate come first, by q90/95. Scores that exceed it (!) or"
        " have too few records to tell (?) follow. A bold q90/95 (in plain text *) is Pareto-optimal: no"
        " other score detects a smaller leak with the same or fewer sensors."
    )
    table = Table(tuple(columns), "All scores", "scores", tuple(notes))
    return Block("ranking", "Ranking", (order,), (table,), ("ranking",))


def _foremost(detection: Detection, most: int) -> tuple[list[Judgement], Column]:
    """The foremost scores that have a threshold, and their names."""
    shown = [each for each in wording.foremost(detection, most) if each.threshold is not None]
    return shown, Column("Score", [each.name for each in shown], is_text=True)


def false_alarms_block(detection: Detection) -> Block | None:
    """Rates on the healthy test records, each shift and each confusion; None if nothing was tested."""
    (shown, names), rules, total = _foremost(detection, _MOST_ALARMS), detection.rules, detection.judgements
    populations = wording.tested(detection, *SOUND)
    if not populations:
        return None
    columns = []
    for each in populations:
        strong = _places(each in judgement.exceeded for judgement in shown)
        columns.append(replace(_rates(f"{each.name} [%]", shown, each), strong=strong))
    left_out = f" {len(shown)} of {counted(len(total), 'score')}; CSV and JSON have all."
    sentence = (
        f"Thresholds are set for {100.0 * rules.false_alarm_rate:g} % on healthy fit records. Bold (in plain"
        f" text *): significantly more alarms than the threshold allows ({100.0 * rules.confidence:g} %"
        " confidence). A score without false alarms in a shift is of use only where it finds leaks as well."
        f" In parentheses the {100.0 * rules.confidence:g} % interval (Clopper and Pearson)."
        f"{left_out if len(shown) < len(total) else ''}"
    )
    title = "Fresh healthy records, shifts and other faults"
    table = Table((names, *columns), title, "shifts")
    return Block("false-alarms", "False alarms", (sentence,), (table,), ("false_alarms", "densities"))


def _rates(title: str, shown: Sequence[Judgement], population: Population) -> Column:
    return Column(title, [wording.rate_text(each.of(population)) for each in shown])


def _places(are_strong: Iterable[bool]) -> tuple[int, ...]:
    return tuple(index for index, is_strong in enumerate(are_strong) if is_strong)


def levels_block(detection: Detection) -> Block | None:
    """Detections at each level by the foremost scores; None if no fault was tested."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if not levels:
        return None
    unit, least = wording.severity_unit(detection), detection.rules.probability
    shown, names = _foremost(detection, _MOST_LEVELS)
    columns = [names]
    for level in levels:
        own = [each.of(level) for each in shown]
        texts = [wording.rate_text(each, with_interval=False) for each in own]
        strong = _places(
            bool(each and each.found and each.found.value >= least and not each.is_counted) for each in own
        )
        columns.append(Column(f"{unit.value(level.severity):.3g}", texts, strong=strong))
    title = f"Detected [%] at each {unit.quantity}{unit.bracket}"
    note = f"Bold (in plain text *): {100.0 * least:g} % or more. All scores are in JSON and CSV."
    paragraph = (
        "Points are the tested levels, curves are fitted over the true severity of each record. "
        "Results come from the curve if it describes the points, otherwise only from the levels."
    )
    table = Table(tuple(columns), title, "levels", (note,))
    return Block("levels", "Probability of detection", (paragraph,), (table,), ("pod", "roc"))


_MOST_COLUMNS = 6


def designs_block(detections: Sequence[Detection]) -> Block | None:
    """What each design finds with each set of sensors; None for a single design."""
    if len(detections) < 2:
        return None
    unit, rules = wording.severity_unit(detections[0]), detections[0].rules
    sentence = (
        "Each design repeats the study with the same actuators. Columns: the best score with no more than"
        " these sensors in each design, and the wavelet rules."
    )
    title = f"q{100.0 * rules.probability:g}/{100.0 * rules.confidence:g}{unit.bracket}"
    rows = [*map(_by_sensors, detections)]
    columns = [Column("Design", [_label(detections[0], each) for each in detections], is_text=True)]
    for name in [*dict.fromkeys(name for row in rows for name in row)][:_MOST_COLUMNS]:
        columns.append(Column(name, [unit.found(row[name].bound) if name in row else HOLE for row in rows]))
    table = Table(tuple(columns), title, "designs", breaks=(1,))
    return Block("designs", "Comparison of designs", (sentence,), (table,))


def _by_sensors(detection: Detection) -> dict[str, Judgement]:
    names = {frozenset(each.scored.channels): wording.sensors(each) for each in detection.judgements}
    best = {names[channels]: each for channels, each in wording.best_with_sensors(detection).items()}
    return best | {each.name: each for each in wording.wavelet_rules(detection)}


def _label(first: Detection, detection: Detection) -> str:
    """What a design changes of the first one, which is named by what it sets."""
    names: dict[str, list[str]] = defaultdict(list)
    for name, value in detection.records.design.items():
        if detection is first or first.records.design.get(name) != value:
            names[shown_value(name, value)].append(name)
    return ", ".join(f"{', '.join(alike)} = {value}" for value, alike in names.items()) or "as configured"


_KINDS = {
    (Kind.HEALTHY, True): "healthy, for thresholds",
    (Kind.HEALTHY, False): "healthy, for testing",
    (Kind.FAULT, True): "leaking, for training",
    (Kind.FAULT, False): "leaking, for testing",
    (Kind.SHIFT, False): "healthy, shifted",
    (Kind.CONFUSION, False): "another fault",
}
_GROUPS = {Kind.HEALTHY: "healthy", Kind.FAULT: "leaking"}


def populations_block(detection: Detection, experiment: ExperimentConfig | None) -> Block:
    """The populations, and for a simulated study what varies."""
    study = experiment.study if experiment else None
    unit, records = wording.severity_unit(detection), detection.records
    changes = {**study.shifts, **study.confusions} if study else {}
    shown = [population for population in records.populations if population.kind is not Kind.ALONE]
    rows: list[dict[str, Any]] = []
    for each in shown:
        severity = records.severity[records.rows(each)]
        known = severity[np.isfinite(severity)]
        rows.append({
            "population": each.name,
            "kind": _KINDS.get((each.kind, each.is_fit), str(each.kind)),
            "records": severity.size,
            unit.key: unit.value(each.severity),
            f"true_mean{unit.suffix}": unit.value(float(known.mean())) if known.size else None,
            "what_differs": shown_values(changes.get(each.name, {})),
        })  # fmt: skip
    if alone := records.chosen(Kind.ALONE, is_fit=False):
        n = sum(records.rows(each).size for each in alone)
        rows.append({"population": "each nuisance alone", "kind": "healthy, for explanation", "records": n})
    note = f"True mean: mean {unit.quantity}{unit.bracket} over each record, averaged over the records."
    breaks = group_breaks([_GROUPS.get(each.kind) for each in shown])
    tables = [Table.of_records(rows, title="Populations", key="populations", notes=(note,), breaks=breaks)]
    if study:
        drawn = {**study.population.over, **study.population.per_record}
        varied = {name: shown_value(name, own) for name, own in drawn.items() if not name.endswith("seed")}
        title = "What varies in all fault-free populations"
        columns = {"Parameter": [*varied], "Values": [*varied.values()]}
        tables.append(Table.of(columns, title=title, key="varied"))
    return Block("populations", "The records", (_FIT,), tuple(tables))


_FIT = "Thresholds are set only on healthy fit records, results come from others."
_WHY = (
    "All records here are healthy; what differs from record to record on one actuator has a row of its own."
    " Alone: central 90 % range of the score while only this varies, relative to the range while all vary,"
    " with its interval. Looks like: the severity that a healthy record in twenty looks like, or more."
    " Further nuisances are in JSON."
)
_MOST_MOVED, _MOST_ROWS = 8, 6
"""Scores that are shown, and nuisances of each."""


def why_block(detection: Detection) -> Block | None:
    """Which nuisance moves which score, the best with each set of sensors; None without records for it."""
    best = wording.best_with_sensors(detection).values()
    chosen = dict.fromkeys((*best, *wording.wavelet_rules(detection), *detection.judgements[:1]))
    by_score = {each.name: nuisances(detection, each.name) for each in [*chosen][:_MOST_MOVED]}
    shown, unit = {name: own for name, (own, _) in by_score.items() if own}, wording.severity_unit(detection)
    if not shown:
        return None

    def size(nuisance: Nuisance) -> float:
        return float(comparable(nuisance.alone.value)) if nuisance.alone else -math.inf

    def row(score: str, nuisance: Nuisance) -> dict[str, str | None]:
        """A share in percent with its interval, such as ``26 (4 … 55)``, and the leak that it looks like."""
        alone, leak, share, looks = nuisance.alone, nuisance.imitated, HOLE, HOLE
        if alone is not None:
            value, low, high = (f"{100.0 * part:.0f}" for part in (alone.value, alone.low, alone.high))
            share = f"{value} ({low} … {high})".replace(" ", "\N{NO-BREAK SPACE}")
        if leak is not None:
            sign = {"below": "<", "above": ">"}.get(leak.place, "")
            looks = sign + two_digits(unit.value(leak.severity))
        name = "record to record" if nuisance.parameter == NOTHING else nuisance.parameter
        return {"score": score, "nuisance": name, "alone_percent": share, f"looks_like{unit.suffix}": looks}

    rows = [
        row(name, each)
        for name, own in shown.items()
        for each in [*sorted(own[:-1], key=size, reverse=True)[:_MOST_ROWS], *own[-1:]]
    ]
    table = Table.of_records(
        rows, key="nuisances", n_lead=2, breaks=group_breaks([row["score"] for row in rows])
    )
    refused = dict.fromkeys(refusal for _, refusals in by_score.values() for refusal in refusals)
    said = (_WHY, *(f"Not stated for some: {refusal}." for refusal in refused))
    return Block("why", "Why: what moves healthy scores", said, (table,))


_CHARTS = (
    "Charts leave out the transient of the estimator and restart after each alarm. Healthy fit records, "
    "resampled whole and joined, set the limits; all results come from other records. A delay is the"
    " time from the onset of a leak to the first alarm after it; alarms before it are false ones (early)."
)


_DULL = ("unit", "kind", "not_measurable")


def run_lengths_block(detection: Detection) -> Block:
    """Delays of detection for each time between false alarms, alarms, and why a chart has none."""
    lines, confidence = [*run_length_lines(detection)], f"{100.0 * detection.rules.confidence:g} %"
    refusals = [chart_record(chart) | {"refused": why}
                for chart in detection.charts for why in chart.refusals]  # fmt: skip
    note = f"low, high: {confidence} interval. –: longer than the records, or no alarm in them."
    delays = [line for line in lines if "found" in line]
    alarms = [line for line in lines if "alarms" in line]
    title = "Mean time between false alarms, as measured"
    tables = (
        Table.of_records(delays, _DULL, title="Delay after the onset", key="delays"),
        Table.of_records(alarms, _DULL, title=title, key="times-between-false-alarms", notes=(note,)),
        Table.of_records(refusals, _DULL, title="Not stated"),
    )
    figures = ("delays",) if any(chart.delays for chart in detection.charts) else ()
    return Block("run-lengths", "Delay in operation", (_CHARTS,), tables, figures)


_ORDER = (
    "The truth is known only for simulated records, and no indicator sees it. Error: estimate minus truth."
)


def estimates_block(data: ExperimentData, rows: list[dict[str, Any]]) -> Block | None:
    """How far estimates are from the truth; None if nothing is estimated."""
    if not rows:
        return None
    level = f"{100.0 * data.experiment.detection.confidence:g} %"
    note = (
        f"Leakage: the flow of K_i at {REFERENCE_DROP / 1e6:g} MPa. Deviations: 1σ of the errors, and as"
        f" stated (root mean square). Covered: share of the records whose stated {level} interval contains"
        f" the truth, with its {level} interval."
    )
    if data.experiment.leakage.onset != "constant":
        note += " Faults are left out: leaks set in during the record, so there is no single true value."
    if without := [name for name, _ in estimated(data) if f"{name}{ERROR}" not in data.columns]:
        note += f" Not listed because they state no deviation: {joined(without)}."
    breaks = group_breaks([(row["indicator"], row["quantity"]) for row in rows])
    title = "Estimates against the truth"
    table = Table.of_records(rows, title=title, key="estimates", notes=(note,), breaks=breaks)
    return Block("estimates", "Estimates", (_ORDER,), (table,))
