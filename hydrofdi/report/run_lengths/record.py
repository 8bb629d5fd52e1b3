"""Judged charts as plain data for JSON, and as tidy columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from hydrofdi.detectors.run_lengths import Delay
from hydrofdi.evaluation.populations import Population
from hydrofdi.report.detection.wording import severity_unit_of
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.run_lengths.wording import hours
from hydrofdi.studies.run_lengths.judgement import ChartJudgement, LeakDelay, RunLengths
from hydrofdi.units import convert


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
            "design": _design(lengths),
            "refusals": list(chart.refusals),
        }
        for lengths in judged
        for chart in lengths.charts
    ]


def run_length_lines(judged: Sequence[RunLengths]) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each chart, limit and tested population."""
    for lengths in judged:
        for chart in lengths.charts:
            lead = {**_design(lengths), **_lead(chart)}
            for population in chart.false_alarms:
                yield lead | _population(lengths, population) | _alarm_record(chart, population)
            for delay in chart.delays:
                yield lead | _population(lengths, delay.population) | _delay_record(lengths, delay)
            if chart.refusals:
                yield lead


def _design(lengths: RunLengths) -> dict[str, Any]:
    return {
        name: finite(value) if isinstance(value, float) else value
        for name, value in lengths.records.design.items()
    }


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
    unit = severity_unit_of(lengths.records)
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
        "between_alarms_h": _hours(found.mean_time),
        "between_alarms_low_h": _hours(found.low),
        "between_alarms_high_h": _hours(found.high),
        "keeps_false_alarm_rate": None if keeps is None else int(keeps),
    }


def _hours(duration: float) -> float | None:
    return finite(hours(duration))


def _delay_record(lengths: RunLengths, delay: LeakDelay) -> dict[str, Any]:
    unit = severity_unit_of(lengths.records)
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
