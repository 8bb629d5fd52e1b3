"""The answer on delays in plain English, with the evidence of healthy test records."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.wording import severity_unit_of
from hydrofdi.report.run_lengths.wording import delay_cell, mean_time_text, time_text
from hydrofdi.report.wording import joined
from hydrofdi.settings.counting import counted
from hydrofdi.studies.run_lengths.judgement import ChartJudgement, LeakDelay, RunLengths, time_needed


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
        yield from _at_one_time(lengths, longest, charts)


def _at_one_time(lengths: RunLengths, every: float, charts: Sequence[ChartJudgement]) -> Iterator[str]:
    asked, kept = time_text(every), [chart for chart in charts if not _is_exceeded(chart)]
    if not kept:
        measured = "; ".join(f"{_times(chart)} with {chart.label}" for chart in charts)
        yield (
            f"Healthy test records alarm more often than once in {asked} at every limit set for that:"
            f" {measured}."
        )
        return
    quickest = _quickest(kept)
    by_any = f" of the quickest of {counted(len(kept), 'chart')}" if len(kept) > 1 else ""
    stated = [
        f"{delay_cell(delay.median, delay.watched).text} s at {_name(lengths, leak)} ({chart.label})"
        for leak, (delay, chart) in quickest.items()
        if _finds_half(delay)
    ]
    missed = [_name(lengths, leak) for leak, (delay, _) in quickest.items() if not _finds_half(delay)]
    at = f"At limits set for one false alarm in {asked} of operation"
    if stated:
        yield f"{at}, the median delay{by_any} after the onset of a leak is {joined(stated)}."
    if missed:
        yield f"{'' if stated else f'{at}: '}Fewer than half of the leaks of {joined(missed)} are found."
    named = dict.fromkeys(chart.label for delay, chart in quickest.values() if _finds_half(delay))
    yield " ".join(_measured(chart) for chart in kept if chart.label in named)


def _quickest(charts: Sequence[ChartJudgement]) -> dict[Population, tuple[LeakDelay, ChartJudgement]]:
    found: dict[Population, list[tuple[LeakDelay, ChartJudgement]]] = {}
    for chart in charts:
        for delay in chart.delays:
            found.setdefault(delay.population, []).append((delay, chart))
    return {
        leak: min(pairs, key=lambda pair: (pair[0].median.value, pair[0].late.value))
        for leak, pairs in found.items()
    }


def _name(lengths: RunLengths, leak: Population) -> str:
    return severity_unit_of(lengths.records).text(leak.severity)


def _finds_half(delay: LeakDelay) -> bool:
    return delay.n_found * 2 >= delay.n


def _is_exceeded(chart: ChartJudgement) -> bool:
    """Whether healthy test records are shown to alarm more often than the limit allows."""
    return any(chart.keeps(each) is False for each in _healthy(chart))


def _healthy(chart: ChartJudgement) -> list[Population]:
    return [each for each in chart.false_alarms if each.kind is Kind.HEALTHY]


def _times(chart: ChartJudgement) -> str:
    return joined([f"once in {mean_time_text(chart.false_alarms[each])}" for each in _healthy(chart)])


def _measured(chart: ChartJudgement) -> str:
    """How often healthy test records alarm, and whether the limit keeps its rate."""
    healthy = _healthy(chart)
    if not healthy:
        return f"No healthy test records show how often {chart.label} alarms while healthy."
    found = chart.false_alarms[healthy[0]]
    often = (
        f"raise no alarm with {chart.label} in {time_text(found.duration)}"
        if math.isinf(found.mean_time)
        else f"alarm with {chart.label} {_times(chart)}"
    )
    if chart.keeps(healthy[0]):
        return f"Healthy test records {often}: not shown to be more often than set."
    needed = time_needed(chart.false_alarm_every, found.confidence) / (found.duration / found.n_group)
    return (
        f"Healthy test records {often}: too few hours to tell whether that is as set;"
        f" {counted(math.ceil(needed), 'record')} are needed."
    )
