"""The section on control charts: delays of detection, and alarms on healthy actuators."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hydrofdi.evaluation.populations import Population
from hydrofdi.report.detection.wording import probability_in_words, severity_unit_of
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.run_lengths.answer import delay_answer
from hydrofdi.report.run_lengths.wording import between_alarms_cell, delay_cell, hours, time_text
from hydrofdi.report.wording import flow_text, joined
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.run_lengths.judgement import ChartJudgement, LeakDelay, RunLengths

_ORDER = (
    "Charts leave out the transient of the estimator and restart after each alarm. Healthy fit records, "
    "resampled whole and joined, set the limits; all results come from other records. A delay is the"
    " time from the onset of a leak to the first alarm after it; alarms before it are false ones (early)."
)


def run_lengths_block(lengths: RunLengths) -> Block:
    """Delays of detection for each time between false alarms."""
    sheets = (_delays_sheet(lengths), _false_alarms_sheet(lengths))
    has_delays = any(chart.delays for chart in lengths.charts)
    return Block(
        "run-lengths",
        "Delay in operation",
        (*delay_answer(lengths), _ORDER, *_refusals(lengths)),
        sheets,
        ("delays",) if has_delays else (),
    )


def _refusals(lengths: RunLengths) -> Iterator[str]:
    """Refused statements with their reasons, once for all charts that share a reason."""
    charts: dict[tuple[float, str], list[str]] = {}
    for chart in lengths.charts:
        for refusal in chart.refusals:
            charts.setdefault((chart.false_alarm_every, refusal), []).append(chart.label)
    for (every, refusal), labels in charts.items():
        yield f"{joined(labels)} at one false alarm in {time_text(every)}: {refusal}."


def _delays_sheet(lengths: RunLengths) -> Sheet:
    unit = severity_unit_of(lengths.records)
    pairs = [(chart, delay) for chart in lengths.charts for delay in chart.delays]
    share = f"{100.0 * lengths.share:g} %"
    headers = (
        "Chart", "Every", f"Leakage [{unit.name or '1'}]", "After onset [L/min]", "Found",
        "Median [s]", f"{share} [s]", "Early",
    )  # fmt: skip
    note = (
        f"Every: mean time between false alarms that the limit is set for. After onset: true mean leakage"
        f" from the onset on. In parentheses the {100.0 * lengths.confidence:g} % interval, from order"
        f" statistics; {share}: {probability_in_words(lengths.share)} the leak is found within this time."
    )
    return Sheet(
        "delays",
        "Delay after the onset",
        headers,
        tuple(_delay_row(chart, delay, unit.value(delay.population.severity)) for chart, delay in pairs),
        group_breaks([(chart.label, chart.false_alarm_every) for chart, _ in pairs]),
        (0,),
        note,
    )


def _delay_row(chart: ChartJudgement, delay: LeakDelay, severity: float) -> tuple[Cell, ...]:
    return (
        Cell(chart.label),
        _every_cell(chart),
        Cell(f"{severity:.3g}", value=severity),
        Cell(flow_text(delay.flow)),
        Cell(f"{delay.n_found} of {delay.n}"),
        delay_cell(delay.median, delay.watched),
        delay_cell(delay.late, delay.watched),
        Cell(str(delay.n_early), value=float(delay.n_early)),
    )


def _false_alarms_sheet(lengths: RunLengths) -> Sheet:
    charts = [chart for chart in lengths.charts if chart.limit is not None]
    populations = list(dict.fromkeys(each for chart in charts for each in chart.false_alarms))
    headers = (
        "Chart", "Watches", "Rule", "Every", "Limit",
        *(each.name for each in populations),
    )  # fmt: skip
    return Sheet(
        "times-between-false-alarms",
        "Mean time between false alarms, as measured",
        headers,
        tuple(_alarm_row(chart, populations) for chart in charts),
        group_breaks([chart.label for chart in charts]),
        (0, 1, 2),
        _note(lengths, charts, populations),
    )


def _alarm_row(chart: ChartJudgement, populations: Sequence[Population]) -> tuple[Cell, ...]:
    assert chart.limit is not None
    cells = (between_alarms_cell(chart, each) for each in populations)
    lead = (Cell(chart.label), Cell(chart.watched), Cell(chart.rule), _every_cell(chart))
    return (*lead, Cell(f"{chart.limit.value:.4g}", value=chart.limit.value), *cells)


def _every_cell(chart: ChartJudgement) -> Cell:
    return Cell(time_text(chart.false_alarm_every), value=hours(chart.false_alarm_every))


def _note(lengths: RunLengths, charts: Sequence[ChartJudgement], populations: Sequence[Population]) -> str:
    watched = [
        f"{each.name} {time_text(chart.false_alarms[each].duration)}"
        for each in populations
        for chart in charts[:1]
        if each in chart.false_alarms
    ]
    return (
        f"In parentheses the {100.0 * lengths.confidence:g} % interval, in the unit before it; > without an"
        " alarm. Bold (in plain text !): shown to alarm more often than the limit is set for; ?:"
        " watched for too short a time to tell."
        f" Watched: {', '.join(watched) or HOLE}."
    )
