"""Beside the scores of a study: delays and alarms of its control charts, and estimates against the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from hydrofdi.evaluation.scores import Estimate, Population
from hydrofdi.report.detection.record import design_record
from hydrofdi.report.detection.wording import severity_unit
from hydrofdi.report.document import Block
from hydrofdi.report.wording import joined
from hydrofdi.studies.detecting import REFERENCE_PRESSURE, Estimates
from hydrofdi.studies.records import ChartJudgement, Detection, LeakDelay
from hydrofdi.tables.table import Table, finite, group_breaks
from hydrofdi.units import convert

_CHARTS = (
    "Charts leave out the transient of the estimator and restart after each alarm. Healthy fit records, "
    "resampled whole and joined, set the limits; all results come from other records. A delay is the"
    " time from the onset of a leak to the first alarm after it; alarms before it are false ones (early)."
)


_DULL = ("unit", "kind", "not_measurable")


def run_lengths_block(detection: Detection) -> Block:
    """Delays of detection for each time between false alarms, alarms, and why a chart has none."""
    lines, confidence = [*_lines(detection)], f"{100.0 * detection.rules.confidence:g} %"
    refusals = [_lead(chart) | {"refused": why} for chart in detection.charts for why in chart.refusals]
    note = f"low, high: {confidence} interval. –: longer than the records, or no alarm in them."
    tables = (
        Table.of_records(
            [line for line in lines if "found" in line], _DULL, title="Delay after the onset", key="delays"
        ),
        Table.of_records(
            [line for line in lines if "alarms" in line],
            _DULL,
            title="Mean time between false alarms, as measured",
            key="times-between-false-alarms",
            notes=(note,),
        ),
        Table.of_records(refusals, _DULL, title="Not stated"),
    )
    figures = ("delays",) if any(chart.delays for chart in detection.charts) else ()
    return Block("run-lengths", "Delay in operation", (_CHARTS,), tables, figures)


def run_length_records(detections: Sequence[Detection]) -> list[dict[str, Any]]:
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
                {"population": delay.population.name} | _delay_record(detection, delay)
                for delay in chart.delays
            ],
            "design": design_record(detection),
            "refusals": list(chart.refusals),
        }
        for detection in detections
        for chart in detection.charts
    ]


def run_length_lines(detections: Sequence[Detection]) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each chart, limit and tested population."""
    for detection in detections:
        yield from (design_record(detection) | line for line in _lines(detection))


def _lines(detection: Detection) -> Iterator[dict[str, Any]]:
    unit = severity_unit(detection)
    for chart in detection.charts:
        lead, stated = _lead(chart), [(each, _alarm_record(chart, each)) for each in chart.false_alarms]
        stated += [(delay.population, _delay_record(detection, delay)) for delay in chart.delays]
        for population, line in stated:
            named = {"population": population.name, "kind": str(population.kind)}
            yield lead | named | {unit.key: unit.value(population.severity)} | line
        if chart.refusals:
            yield lead


def _lead(chart: ChartJudgement) -> dict[str, Any]:
    return {
        "chart": chart.label,
        "rule": chart.rule,
        "indicator": chart.watched,
        "unit": chart.unit,
        "false_alarm_every_h": convert(chart.false_alarm_every, "h"),
        "limit": None if chart.limit is None else chart.limit.value,
    }


def _alarm_record(chart: ChartJudgement, population: Population) -> dict[str, Any]:
    found, keeps = chart.false_alarms[population], chart.keeps(population)
    return {
        "alarms": found.n_alarm,
        "hours": convert(found.duration, "h"),
        "between_alarms_h": finite(convert(found.mean_time, "h")),
        "between_alarms_low_h": finite(convert(found.low, "h")),
        "between_alarms_high_h": finite(convert(found.high, "h")),
        "keeps_false_alarm_rate": None if keeps is None else int(keeps),
    }


def _delay_record(detection: Detection, delay: LeakDelay) -> dict[str, Any]:
    unit = severity_unit(detection)
    return {
        unit.key: unit.value(delay.population.severity),
        "true_mean_flow_after_onset_L_per_min": finite(convert(delay.flow, "L/min")),
        "found": delay.n_found,
        "n": delay.n,
        "false_alarms_before_onset": delay.n_early,
        "not_measurable": delay.not_measurable,
        **_quantile("delay_median", delay.median),
        **_quantile(f"delay_{100.0 * detection.rules.probability:g}_percent", delay.late),
    }


def _quantile(name: str, delay: Estimate) -> dict[str, float | None]:
    """In s; None if records end before."""
    ends = {f"{name}_s": delay.value, f"{name}_low_s": delay.low, f"{name}_high_s": delay.high}
    return {key: finite(value) for key, value in ends.items()}


_ORDER = (
    "The truth is known only for simulated records, and no indicator sees it. Error: estimate minus truth."
)


def estimates_block(estimates: Estimates) -> Block | None:
    """How far estimates are from the truth; None if nothing is estimated."""
    if not (rows := estimates.rows):
        return None
    level = f"{100.0 * estimates.confidence:g} %"
    note = (
        f"Leakage: the flow of K_i at {REFERENCE_PRESSURE / 1e6:g} MPa. Deviations: 1σ of the errors, and as"
        f" stated (root mean square). Covered: share of the records whose stated {level} interval contains"
        f" the truth, with its {level} interval.{_left_out(estimates)}"
    )
    breaks = group_breaks([(each["indicator"], each["quantity"]) for each in rows])
    title = "Estimates against the truth"
    table = Table.of_records(rows, title=title, key="estimates", notes=(note,), breaks=breaks)
    return Block("estimates", "Estimates", (_ORDER,), (table,))


def _left_out(estimates: Estimates) -> str:
    """Sentences on what the table does not list, and why."""
    sentences = ""
    if not estimates.has_constant_leaks:
        sentences += " Faults are left out: leaks set in during the record, so there is no single true value."
    if estimates.without_deviation:
        sentences += f" Not listed because they state no deviation: {joined(estimates.without_deviation)}."
    return sentences
