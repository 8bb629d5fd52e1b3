"""What a detector promises, and what that rests on; what an alarm comes to, and what to do next."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hydrofdi.detectors.file import LIKE, DetectorFile
from hydrofdi.detectors.verdicts import Leak, coverage
from hydrofdi.evaluation.rates import FEWEST_GROUPS
from hydrofdi.indicators.nominal_actuator import assumption_text, plant_constants
from hydrofdi.settings.messages import (
    convert,
    count_text,
    counted,
    number_text,
    percent,
    plain,
    shown_quantity,
    time_text,
)

_CHANCE, _FAR = 0.01, 10.0
"""Probability of as many false alarms below which they are not chance, and healthy spreads beyond the limit
from which on a single alarm is not."""

_PAGE = "docs/how-to/after-an-alarm.md"


def consequence(
    file: DetectorFile, windows_judged: int, alarms: int, leak: Leak | None, margin: float | None = None
) -> tuple[str, dict[str, Any]]:
    """What alarms come to, of which one, or the median, has a size and a margin: in words that end with what
    to do next, and for JSON with units in the names, None where a number is not known.

    The drift is the speed of the piston if the flow of the leak passes it while both ports are closed.
    """
    options = file.feature.indicator.options
    assumed = None if "piston_area" in file.assumed else getattr(options, "piston_area", None)
    area = file.data_sheet.get("piston_area", assumed)
    expected, chart = windows_judged * file.limits.false_alarm_rate, file.config.chart
    if chart is not None:
        # at least those of the chart itself
        expected = windows_judged * (file.n_every / file.sampling_frequency / chart.false_alarm_every)
    drift = 6e4 * (max(0.0, leak.flow) / area) if leak and area else None
    advice = _advice(file, alarms, expected, margin)
    texts = [f"{counted(alarms, 'alarm')} until now, {count_text(expected)} expected of a healthy machine"]
    if leak is not None:
        moving = "" if drift is None else f", a drift of {number_text(drift, 2)} mm/min"
        texts.append(f"{leak}{moving}")
    return "; ".join([*texts, advice]), {
        "windows_judged": windows_judged,
        "alarms": alarms,
        "false_alarms_expected": expected,
        "flow_L_per_min": leak and convert(leak.flow, "L/min"),
        "flow_interval_L_per_min": leak and [convert(each, "L/min") for each in leak.interval],
        "drift_mm_per_min": drift,
        "recommendation": advice,
    }


def _advice(file: DetectorFile, alarms: int, expected: float, margin: float | None) -> str:
    from scipy.special import pdtrc

    is_far = margin is not None and margin < -_FAR
    if file.chart is not None or is_far or (alarms and pdtrc(alarms - 1, expected) < _CHANCE):
        first = "check the signals ('hydrofdi inspect'), then 'hydrofdi diagnose'"
        return f"more than chance explains: {first} ({_PAGE})"
    return f"this may be chance: wait and see whether most of the next ten windows alarm, too ({_PAGE})"


_HOUR = 3600.0
_MOST_NAMED = 5

_UNEVEN = 0.75
"""Samples per period by which a window may miss whole periods: the period is known to half a sample."""


def sentences(
    file: DetectorFile, n_leaking: int = 0, n_unlabelled: int = 0, *, is_unlabelled: bool = False
) -> Iterator[str]:
    """What the detector judges, what it promises, and what that rests on.

    Parameters
    ----------
    n_leaking, n_unlabelled : int
        Records that the training left out.
    is_unlabelled : bool
        Whether all records were taken as healthy because no source says which are.
    """
    feature, window = file.feature, file.config.window
    channels = ", ".join(f"{channel.symbol} ({channel})" for channel in file.channels)
    what = {
        "time": f"windows of {window.duration:g} s" if window.duration else "",
        "cycle": f"the first {window.duration or 0.0:g} s of each cycle of {window.channel}",
    }[window.by]
    every = f", one every {window.every:g} s," if window.every and window.every != window.duration else ""
    yield f"It judges {what}{every} at {file.sampling_frequency:g} Hz and needs {channels}."
    if len(feature.judged) > 1:
        first, second = feature.judged
        yield (
            f"It alarms by {first}, {LIKE[0]}, or by {second}, {LIKE[1]}; they keep the false-alarm rate"
            " together. An alarm states the mean flow of any law."
        )
    elif file.score is not None:
        yield f"It combines {counted(len(file.score.numbers), 'number')}: {', '.join(file.score.numbers)}."
    machines = (
        ", ".join(
            f"{name} = {shown_quantity(getattr(each.options, name), unit)}"
            for name, unit in plant_constants(each.options).items()
            if getattr(each.options, name)
        )
        for each in feature.indicators.values()
    )
    yield from (f"It takes the actuator as {each}." for each in dict.fromkeys(machines) if each)
    if file.assumed:
        assuming = (
            label
            for label, each in feature.indicators.items()
            if not type(each.options).model_fields.keys().isdisjoint(file.assumed)
        )
        yield f"Warning: {assumption_text(', '.join(assuming), file.assumed)}."
    if " at " in (meaning := feature.meaning):
        yield f"The score is the {meaning}; an alarm states the mean flow of any law."
    if file.chart is None:
        yield f"A score {file.alarm_text} is an alarm."
        yield _threshold(file)
    out = {
        "not judged": ", ".join(f"{count:,} {kind}" for kind, count in file.basis.not_judged.items()),
        "records that are not healthy training records": n_leaking,
        "records without a label": n_unlabelled,
    }
    yield from _basis(file, "; ".join(f"{kind} ({count})" for kind, count in out.items() if count))
    yield from _cautions(file, is_unlabelled=is_unlabelled)
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
    rests = {
        "windows": "windows taken as independent",
        "fleet": f"{counted(file.basis.n_window, 'own window')} and the fleet {file.basis.fleet}",
    }.get(limits.interval_rests_on, f"leave-one-{limits.interval_rests_on[:-1]}-out")
    warmer = f" The limit allows {file.score_text(limits.allowance)} for oil that is 15 K warmer than in the"
    warmer += " records, which do not state its temperature."
    return (
        f"Designed for a false-alarm rate of {at_most}{percent(limits.false_alarm_rate)} per window;"
        f" {100.0 * limits.confidence:.4g} % confidence interval"
        f" {percent(low)} to {percent(high)} ({rests}){hourly}."
        f"{warmer if limits.allowance else ''}"
    )


def _basis(file: DetectorFile, left_out: str) -> Iterator[str]:
    """What the promise rests on."""
    basis = file.basis
    groups = f" in {counted(basis.n_group, 'group')}" if basis.n_group else ""
    records, n_more = counted(basis.n_record, "healthy record"), len(basis.sources) - _MOST_NAMED
    names = ", ".join(basis.sources[:_MOST_NAMED]) + (f" and {n_more:,} more" if n_more > 0 else "")
    yield f"It rests on {basis.n_window:,} windows that do not overlap, from {records}{groups}: {names}."
    if left_out:
        yield f"Left out: {left_out}."
    yield coverage(file.conditions)


def _cautions(file: DetectorFile, *, is_unlabelled: bool) -> Iterator[str]:
    """What makes the promise doubtful."""
    basis, window = file.basis, file.config.window
    is_fit = {name for name, output in file.feature.outputs.items() if output.is_fit}
    for name, count in basis.impossible.items():
        if name not in is_fit:
            yield f"Warning: {name} is beyond what a machine has in {count:,} of them."
    if unfit := [name for name in is_fit if 2 * basis.impossible.get(name, 0) > basis.n_window]:
        likely = f" ({basis.likely})" if basis.likely else ""
        yield (
            f"Warning: by {' and '.join(sorted(unfit))} of most of them, the data sheet does not fit{likely}:"
            " the limits hold for machines like these, but stated sizes of leaks may be wrong."
        )
    if basis.outlying:
        far = [f"{name} ({counted(count, 'window')})" for name, count in basis.outlying.items()]
        more = f" and {len(far) - _MOST_NAMED:,} more" if len(far) > _MOST_NAMED else ""
        yield (
            f"Warning: far beyond the other healthy records: {', '.join(far[:_MOST_NAMED])}{more}."
            " If they are not healthy, a leak is hidden; train without them."
        )
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
    n, one = (basis.n_group, "group") if basis.n_group else (basis.n_record, "record")
    if n < FEWEST_GROUPS:
        yield (
            f"Warning: {counted(n, one)} can say little of false alarms on other days or machines; train on"
            f" {FEWEST_GROUPS} or more."
        )
    if (
        not file.chart
        and file.limits.interval_rests_on == "windows"
        and basis.n_window > max(basis.n_record, basis.n_group)
    ):
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
