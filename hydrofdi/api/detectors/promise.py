"""What a trained detector promises, and what the promise rests on, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Any

from hydrofdi.api.detectors.healthy_records import LeftOut
from hydrofdi.api.measuring import assumption_text, constants_text
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import count_text, percent, plain, time_text

_HOUR = 3600.0
_MOST_NAMED = 5

_UNEVEN = 0.75
"""Samples per period by which a window may miss whole periods: the period is known to half a sample."""

_RESTS = {
    "windows": "windows taken as independent",
    "records": "leave-one-record-out",
    "groups": "leave-one-group-out",
}


def sentences(file: DetectorFile, left_out: LeftOut, *, is_unlabelled: bool) -> Iterator[str]:
    """What the detector judges, what it promises, and what that rests on."""
    feature, name = file.feature, file.config.indicator or ", ".join(file.feature.indicators)
    channels = ", ".join(f"{channel.symbol} ({channel})" for channel in file.channels)
    yield f"It judges {_what(file)} at {file.sampling_frequency:g} Hz and needs {channels}."
    if file.score is not None:
        yield f"It combines {counted(len(file.score.numbers), 'number')}: {', '.join(file.score.numbers)}."
    for constants in dict.fromkeys(constants_text(each.options) for each in feature.indicators.values()):
        if constants:
            yield f"It takes the actuator as {constants}."
    if file.assumed:
        yield f"Warning: {assumption_text(name, file.assumed)}."
    if " at " in (meaning := feature.meaning):
        yield f"The score is the {meaning}; studies state mean flows, which are smaller."
    yield f"A score {file.limits_text} is an alarm."
    yield from _promise(file)
    yield from _basis(file, left_out)
    yield from _doubts(file, is_unlabelled=is_unlabelled)
    yield from _chart(file)


def promise_text(file: DetectorFile) -> str:
    """What the chart promises; without one, what the threshold does."""
    return next(chain(_chart(file), _promise(file)))


def _what(file: DetectorFile) -> str:
    window = file.config.window
    duration, every = window.duration or 0.0, window.every or 0.0
    if window.by == "estimate":
        return f"each estimate of {file.config.indicator}"
    if window.by == "cycle":
        return f"the first {duration:g} s of each cycle of {window.channel}"
    return f"windows of {duration:g} s" + ("" if every == duration else f", one every {every:g} s,")


def _promise(file: DetectorFile) -> Iterator[str]:
    limits, what = file.limits, "window" if file.n_sample else "estimate"
    at_most = "at most " if limits.method == "tolerance limit" else ""
    low, high = map(percent, limits.interval)
    yield (
        f"Designed for a false-alarm rate of {at_most}{percent(limits.false_alarm_rate)} per {what};"
        f" {100.0 * limits.confidence:.4g} % confidence interval {low} to {high}"
        f" ({_RESTS[limits.interval_rests_on]})."
    )
    if per_hour := alarms_per_hour(file):
        least, most = map(count_text, per_hour["interval"])
        window = file.config.window
        overlap = (window.every or 0.0) < (window.duration or 0.0)
        runs = "; they come in runs because windows overlap" if overlap else ""
        yield f"That is {count_text(per_hour['wanted'])} false alarms an hour ({least} to {most}){runs}."
    if not file.n_sample:
        yield "False alarms come in runs, as estimates follow each other closely; a chart accounts for that."


def _basis(file: DetectorFile, left: LeftOut) -> Iterator[str]:
    basis = file.basis
    what = "windows that do not overlap" if file.n_sample else "estimates"
    groups = f" in {counted(basis.n_group, 'group')}" if basis.n_group else ""
    names = [f"{label} ({count:,})" for label, count in basis.populations.items()] or [*basis.sources]
    more = f" and {len(names) - _MOST_NAMED:,} more" if len(names) > _MOST_NAMED else ""
    yield (
        f"It rests on {basis.n_window:,} {what}, from {counted(basis.n_record, 'healthy record')}{groups}:"
        f" {', '.join(names[:_MOST_NAMED])}{more}."
    )
    if basis.not_judged:
        faults = ", ".join(f"{count:,} {kind}" for kind, count in basis.not_judged.items())
        yield f"Healthy {what} that were not used: {faults}."
    for name, count in basis.impossible.items():
        yield f"Warning: {name} is physically impossible in {count:,} of them."
    if left.n_leaking:
        yield f"Left out because they are not healthy training records: {left.n_leaking:,}."
    if left.n_unlabelled:
        yield f"Left out because they have no label: {left.n_unlabelled:,}."


def _doubts(file: DetectorFile, *, is_unlabelled: bool) -> Iterator[str]:
    basis = file.basis
    if basis.drive_period is not None and file.config.window.by == "time":
        periods = (file.config.window.duration or 0.0) / basis.drive_period
        missed = abs(periods - round(periods)) * basis.drive_period * file.sampling_frequency
        if missed > _UNEVEN * max(1.0, periods):
            yield (
                f"Warning: a window lasts {periods:.5g} periods of the drive ({basis.drive_period:g} s), so"
                " windows contain different parts of it; use a whole number of periods."
            )
    if is_unlabelled:
        yield "No record has a label: all are assumed to be healthy."
    if basis.n_record == 1 or basis.n_group == 1:
        one = "record" if basis.n_record == 1 else "group"
        yield f"One {one}: nothing is known of other days or machines."
    if file.limits.interval_rests_on == "windows" and basis.n_window > max(basis.n_record, basis.n_group):
        yield "Windows of one record may depend on each other; then the true interval is wider."
        if not basis.n_group and basis.n_record > 1:
            yield "The interval does not include how records differ, as each has too few windows."


def _chart(file: DetectorFile) -> Iterator[str]:
    chart, config = file.chart, file.config.chart
    if chart is None or config is None:
        if per_hour := alarms_per_hour(file):
            yield (
                f"Without a chart expect {count_text(24.0 * per_hour['wanted'])} false alarms a day; a chart"
                " for one a day needs 24 h of healthy windows."
            )
        return
    mean = "no false alarm"
    if chart.mean_time is not None:
        mean = f"a false alarm every {time_text(chart.mean_time)}"
    least, most = chart.interval
    ends = f"{time_text(least)} to {time_text(most)}" if most is not None else f"at least {time_text(least)}"
    rests = "pieces of records" if chart.rests_on == "pieces" else chart.rests_on
    wanted, lasting = time_text(config.false_alarm_every), time_text(chart.hours * _HOUR)
    yield (
        f"The chart {config.chart} has the limit {plain(chart.limit, 4)} healthy spreads: {mean} ({ends}),"
        f" set for {wanted}, from {lasting} of healthy scores ({rests} resampled and joined)."
    )


def alarms_per_hour(file: DetectorFile) -> dict[str, Any] | None:
    """Alarms of healthy windows per hour of operation; None where windows do not come by time."""
    every, limits = file.config.window.every, file.limits
    if file.config.window.by != "time" or every is None:
        return None
    windows = _HOUR / every
    return {
        "wanted": limits.false_alarm_rate * windows,
        "interval": [share * windows for share in limits.interval],
    }
