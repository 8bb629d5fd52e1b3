"""Control charts of a study: delays of detection, and alarms of healthy actuators."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from hydrofdi.detectors.run_lengths import AlarmLimit, Delay
from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.report.detection.record import design_record
from hydrofdi.report.detection.wording import probability_in_words, severity_unit
from hydrofdi.report.table import Block, Column, Table, finite, group_breaks
from hydrofdi.report.wording import flow_text, joined
from hydrofdi.settings.readable import HOLE, time_text, two_digits
from hydrofdi.studies.charts import ChartJudgement, LeakDelay, RunLengths
from hydrofdi.units import convert

_ORDER = (
    "Charts leave out the transient of the estimator and restart after each alarm. Healthy fit records, "
    "resampled whole and joined, set the limits; all results come from other records. A delay is the"
    " time from the onset of a leak to the first alarm after it; alarms before it are false ones (early)."
)


def run_lengths_block(lengths: RunLengths) -> Block:
    """Delays of detection for each time between false alarms."""
    tables = (_delays_table(lengths), _false_alarms_table(lengths))
    said = (*delay_answer(lengths), _ORDER, *_refusals(lengths))
    figures = ("delays",) if any(chart.delays for chart in lengths.charts) else ()
    return Block("run-lengths", "Delay in operation", said, tables, figures)


def delay_answer(lengths: RunLengths) -> Iterator[str]:
    """For each leak, the quickest chart of those that keep the longest time that has a limit."""
    limited = [chart for chart in lengths.charts if chart.limit is not None]
    with_delays = [chart for chart in limited if chart.delays]
    if not limited:
        yield "No delay is stated: no chart has a limit."
    elif not with_delays:
        yield "No delay is stated: no leak sets in while a chart watches (leakage.onset, leakage.onset_time)."
    else:
        longest = max(chart.false_alarm_every for chart in with_delays)
        charts = [chart for chart in with_delays if chart.false_alarm_every == longest]
        yield from _at_one_time(lengths, time_text(longest), charts)


def _at_one_time(lengths: RunLengths, asked: str, charts: Sequence[ChartJudgement]) -> Iterator[str]:
    kept = [chart for chart in charts if all(chart.keeps(each) is not False for each in _healthy(chart))]
    if not kept:
        measured = "; ".join(f"{_times(chart)} with {chart.label}" for chart in charts)
        yield f"Healthy test records alarm more often than once in {asked} at every limit: {measured}."
        return
    found: dict[Population, list[tuple[LeakDelay, ChartJudgement]]] = {}
    for chart in kept:
        for delay in chart.delays:
            found.setdefault(delay.population, []).append((delay, chart))
    stated = []
    for leak, pairs in found.items():
        delay, chart = min(pairs, key=lambda pair: (pair[0].median.value, pair[0].late.value))
        name, often = severity_unit(lengths).text(leak.severity), _times(chart) or "not measured"
        own = f"{_delay_text(delay.median, delay.watched)} s at {name}"
        stated.append(f"{own} ({chart.label}, whose healthy test records alarm {often})")
    yield (
        f"At limits set for one false alarm in {asked} of operation, the median delay after the onset of a"
        f" leak is {joined(stated)}."
    )


def _healthy(chart: ChartJudgement) -> list[Population]:
    return [each for each in chart.false_alarms if each.kind is Kind.HEALTHY]


def _times(chart: ChartJudgement) -> str:
    return joined([f"once in {mean_time_text(chart.false_alarms[each])}" for each in _healthy(chart)])


def _refusals(lengths: RunLengths) -> Iterator[str]:
    """Refused statements with their reasons, once for all charts that share a reason."""
    charts: dict[tuple[float, str], list[str]] = {}
    for chart in lengths.charts:
        for refusal in chart.refusals:
            charts.setdefault((chart.false_alarm_every, refusal), []).append(chart.label)
    for (every, refusal), labels in charts.items():
        yield f"{joined(labels)} at one false alarm in {time_text(every)}: {refusal}."


def _delays_table(lengths: RunLengths) -> Table:
    unit, share = severity_unit(lengths), f"{100.0 * lengths.share:g} %"
    pairs = [(chart, delay) for chart in lengths.charts for delay in chart.delays]
    delays = [delay for _, delay in pairs]
    columns = (
        Column("Chart", [chart.label for chart, _ in pairs], is_text=True),
        Column("Every", [time_text(chart.false_alarm_every) for chart, _ in pairs]),
        Column(f"Leakage [{unit.name or '1'}]", [f"{unit.value(d.population.severity):.3g}" for d in delays]),
        Column("After onset [L/min]", [flow_text(delay.flow) for delay in delays]),
        Column("Found", [f"{delay.n_found} of {delay.n}" for delay in delays]),
        Column("Median [s]", [_delay_text(delay.median, delay.watched) for delay in delays]),
        Column(f"{share} [s]", [_delay_text(delay.late, delay.watched) for delay in delays]),
        Column("Early", [delay.n_early for delay in delays]),
    )
    note = (
        f"Every: mean time between false alarms that the limit is set for. After onset: true mean leakage"
        f" from the onset on. In parentheses the {100.0 * lengths.confidence:g} % interval, from order"
        f" statistics; {share}: {probability_in_words(lengths.share)} the leak is found within this time."
    )
    breaks = group_breaks([(chart.label, chart.false_alarm_every) for chart, _ in pairs])
    return Table(columns, "Delay after the onset", "delays", (note,), breaks)


def _delay_text(delay: Delay, watched: float) -> str:
    """A delay in s with its interval, such as ``2.3 (2.1–2.6)``; ``> 58``: longer than is watched [s]."""
    beyond = f"> {two_digits(watched)}"
    if math.isinf(delay.value):
        return beyond
    high = beyond if math.isinf(delay.high) else two_digits(delay.high)
    return f"{two_digits(delay.value)} ({two_digits(delay.low)}–{high})"


def _false_alarms_table(lengths: RunLengths) -> Table:
    charts = [chart for chart in lengths.charts if chart.limit is not None]
    populations = list(dict.fromkeys(each for chart in charts for each in chart.false_alarms))
    columns = [
        Column("Chart", [chart.label for chart in charts], is_text=True),
        Column("Watches", [chart.watched for chart in charts], is_text=True),
        Column("Rule", [chart.rule for chart in charts], is_text=True),
        Column("Every", [time_text(chart.false_alarm_every) for chart in charts]),
        Column("Limit", [chart.limit and chart.limit.value for chart in charts]),
    ]
    watched = []
    for each in populations:
        keeps = [chart.keeps(each) for chart in charts]
        texts = [
            mean_time_text(chart.false_alarms[each]) + (" ?" if kept is None else "")
            if each in chart.false_alarms
            else HOLE
            for chart, kept in zip(charts, keeps, strict=True)
        ]
        strong = tuple(place for place, kept in enumerate(keeps) if kept is False)
        columns.append(Column(each.name, texts, strong=strong))
        if each in charts[0].false_alarms:
            watched.append(f"{each.name} {time_text(charts[0].false_alarms[each].duration)}")
    note = (
        f"In parentheses the {100.0 * lengths.confidence:g} % interval, in the unit before it; > without an"
        " alarm. Bold (in plain text *): shown to alarm more often than the limit is set for; ?:"
        f" watched for too short a time to tell. Watched: {', '.join(watched) or HOLE}."
    )
    title = "Mean time between false alarms, as measured"
    breaks = group_breaks([chart.label for chart in charts])
    return Table(tuple(columns), title, "times-between-false-alarms", (note,), breaks)


def hours(duration: float) -> float:
    """A duration [s] in hours."""
    return convert(duration, "h")


def mean_time_text(found: AlarmLimit) -> str:
    """A mean time between alarms with its interval in the same unit, such as ``31 min (12–110)``.

    Without an alarm, the lower end of the interval: ``> 20 min``.
    """
    unit = _unit(found.low if math.isinf(found.mean_time) else found.mean_time)
    low, mean, high = (two_digits(convert(each, unit)) for each in (found.low, found.mean_time, found.high))
    if math.isinf(found.mean_time):
        return f"> {low} {unit}"
    return f"{mean} {unit} ({low}–{'∞' if math.isinf(found.high) else high})"


def _unit(duration: float) -> str:
    """The largest unit in which a duration [s] is at least 1; for shorter ones the second."""
    return next((unit for unit in ("h", "min") if convert(duration, unit) >= 1.0), "s")


def run_length_records(judged: Sequence[RunLengths]) -> list[dict[str, Any]]:
    """One record for each chart at each limit."""
    return [
        {
            **_lead(chart),
            "centre": finite(chart.centre),
            "spread": finite(chart.spread),
            "false_alarms": [
                {"population": each.name, "kind": str(each.kind)} | _alarm_record(chart, each)
                for each in chart.false_alarms
            ],
            "delays": [
                {"population": delay.population.name} | _delay_record(lengths, delay)
                for delay in chart.delays
            ],
            "design": design_record(lengths),
            "refusals": list(chart.refusals),
        }
        for lengths in judged
        for chart in lengths.charts
    ]


def run_length_lines(judged: Sequence[RunLengths]) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each chart, limit and tested population."""
    for lengths in judged:
        for chart in lengths.charts:
            lead = {**design_record(lengths), **_lead(chart)}
            for population in chart.false_alarms:
                yield lead | _population(lengths, population) | _alarm_record(chart, population)
            for delay in chart.delays:
                yield lead | _population(lengths, delay.population) | _delay_record(lengths, delay)
            if chart.refusals:
                yield lead


def _lead(chart: ChartJudgement) -> dict[str, Any]:
    return {
        "chart": chart.label,
        "rule": chart.rule,
        "indicator": chart.watched,
        "unit": chart.unit,
        "false_alarm_every_h": hours(chart.false_alarm_every),
        "limit": None if chart.limit is None else chart.limit.value,
    }


def _population(lengths: RunLengths, population: Population) -> dict[str, Any]:
    unit = severity_unit(lengths)
    return {
        "population": population.name,
        "kind": str(population.kind),
        unit.key: unit.value(population.severity),
    }


def _alarm_record(chart: ChartJudgement, population: Population) -> dict[str, Any]:
    found, keeps = chart.false_alarms[population], chart.keeps(population)
    return {
        "alarms": found.n_alarm,
        "hours": hours(found.duration),
        "between_alarms_h": finite(hours(found.mean_time)),
        "between_alarms_low_h": finite(hours(found.low)),
        "between_alarms_high_h": finite(hours(found.high)),
        "keeps_false_alarm_rate": None if keeps is None else int(keeps),
    }


def _delay_record(lengths: RunLengths, delay: LeakDelay) -> dict[str, Any]:
    unit = severity_unit(lengths)
    return {
        unit.key: unit.value(delay.population.severity),
        "true_mean_flow_after_onset_L_per_min": finite(convert(delay.flow, "L/min")),
        "found": delay.n_found,
        "n": delay.n,
        "false_alarms_before_onset": delay.n_early,
        "not_measurable": delay.not_measurable,
        **_quantile("delay_median", delay.median),
        **_quantile(f"delay_{100.0 * lengths.share:g}_percent", delay.late),
    }


def _quantile(name: str, delay: Delay) -> dict[str, float | None]:
    """In s; None if records end before."""
    ends = {f"{name}_s": delay.value, f"{name}_low_s": delay.low, f"{name}_high_s": delay.high}
    return {key: finite(value) for key, value in ends.items()}
