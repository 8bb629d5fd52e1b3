"""What a trained detector promises, and what the promise rests on, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
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


def sentences(file: DetectorFile, left_out: LeftOut, *, is_unlabelled: bool) -> Iterator[str]:
    """What the detector judges, what it promises, and what that rests on."""
    feature, window = file.feature, file.config.window
    channels = ", ".join(f"{channel.symbol} ({channel})" for channel in file.channels)
    what = {
        "time": f"windows of {window.duration:g} s" if window.duration else "",
        "cycle": f"the first {window.duration or 0.0:g} s of each cycle of {window.channel}",
        "estimate": f"each estimate of {file.config.indicator}",
    }[window.by]
    every = f", one every {window.every:g} s," if window.every and window.every != window.duration else ""
    yield f"It judges {what}{every} at {file.sampling_frequency:g} Hz and needs {channels}."
    if file.score is not None:
        yield f"It combines {counted(len(file.score.numbers), 'number')}: {', '.join(file.score.numbers)}."
    for constants in dict.fromkeys(constants_text(each.options) for each in feature.indicators.values()):
        if constants:
            yield f"It takes the actuator as {constants}."
    if file.assumed:
        yield f"Warning: {assumption_text(', '.join(feature.indicators), file.assumed)}."
    if " at " in (meaning := feature.meaning):
        yield f"The score is the {meaning}; studies state mean flows, which are smaller."
    yield f"A score {file.limits_text} is an alarm."
    yield _threshold(file)
    yield from _basis(file, left_out, is_unlabelled=is_unlabelled)
    if file.chart is not None or alarms_per_hour(file):
        yield promise_text(file)


def promise_text(file: DetectorFile) -> str:
    """What the chart is set for, and what it keeps on healthy scores; without one, what is to be expected."""
    chart, config, per_hour = file.chart, file.config.chart, alarms_per_hour(file)
    if chart is None or config is None:
        if per_hour is None:
            return _threshold(file)
        return (
            f"Without a chart expect {count_text(24.0 * per_hour['wanted'])} false alarms a day; a chart for"
            " one a day needs 24 h of healthy windows."
        )
    kept = "no false alarm" if chart.mean_time is None else f"one in {time_text(chart.mean_time)}"
    least, most = chart.interval
    ends = f"{time_text(least)} to {time_text(most)}" if most is not None else f"at least {time_text(least)}"
    rests = "pieces of records" if chart.rests_on == "pieces" else chart.rests_on
    return (
        f"The chart {config.chart} has the limit {plain(chart.limit, 4)} healthy spreads, set for one false"
        f" alarm in {time_text(config.false_alarm_every)}; its {time_text(chart.hours * _HOUR)} of healthy"
        f" scores ({rests} resampled and joined) show {kept} ({ends})."
    )


def _threshold(file: DetectorFile) -> str:
    limits, (low, high) = file.limits, file.limits.interval
    at_most = "at most " if limits.method == "tolerance limit" else ""
    hourly = ""
    if per_hour := alarms_per_hour(file):
        least, most = map(count_text, per_hour["interval"])
        hourly = f": {count_text(per_hour['wanted'])} false alarms an hour ({least} to {most})"
    rests = {"windows": "windows taken as independent"}.get(
        limits.interval_rests_on, f"leave-one-{limits.interval_rests_on[:-1]}-out"
    )
    return (
        f"Designed for a false-alarm rate of {at_most}{percent(limits.false_alarm_rate)} per"
        f" {'window' if file.n_sample else 'estimate'}; {100.0 * limits.confidence:.4g} % confidence interval"
        f" {percent(low)} to {percent(high)} ({rests}){hourly}."
    )


def _basis(file: DetectorFile, left: LeftOut, *, is_unlabelled: bool) -> Iterator[str]:
    basis, window = file.basis, file.config.window
    groups = f" in {counted(basis.n_group, 'group')}" if basis.n_group else ""
    what = "windows that do not overlap" if file.n_sample else "estimates"
    records, n_more = counted(basis.n_record, "healthy record"), len(basis.sources) - _MOST_NAMED
    names = ", ".join(basis.sources[:_MOST_NAMED]) + (f" and {n_more:,} more" if n_more > 0 else "")
    yield f"It rests on {basis.n_window:,} {what}, from {records}{groups}: {names}."
    counts = {
        "not judged": ", ".join(f"{count:,} {kind}" for kind, count in basis.not_judged.items()),
        "records that are not healthy training records": left.n_leaking,
        "records without a label": left.n_unlabelled,
    }
    if out := "; ".join(f"{kind} ({count})" for kind, count in counts.items() if count):
        yield f"Left out: {out}."
    for name, count in basis.impossible.items():
        yield f"Warning: {name} is physically impossible in {count:,} of them."
    if basis.drive_period is not None and window.by == "time":
        periods = (window.duration or 0.0) / basis.drive_period
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
