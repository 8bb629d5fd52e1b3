"""Times, and times between alarms, as the words of a report."""

from __future__ import annotations

import math

from hydrofdi.detectors.run_lengths import AlarmLimit, Delay
from hydrofdi.evaluation.populations import Population
from hydrofdi.report.document import Cell
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.run_lengths.judgement import ChartJudgement
from hydrofdi.units import convert


def hours(duration: float) -> float:
    """A duration [s] in hours."""
    return convert(duration, "h")


def time_text(duration: float) -> str:
    """A duration [s] with its unit, such as ``24 h`` or ``2.5 min``."""
    unit = _unit(duration)
    return f"{float(f'{convert(duration, unit):.3g}'):,g} {unit}"


def mean_time_text(found: AlarmLimit) -> str:
    """A mean time between alarms with its interval in the same unit, such as ``31 min (12–110)``.

    Without an alarm, the lower end of the interval: ``> 20 min``.
    """
    if math.isinf(found.mean_time):
        unit = _unit(found.low)
        return f"> {_digits(found.low, unit)} {unit}"
    unit = _unit(found.mean_time)
    low, mean = (_digits(each, unit) for each in (found.low, found.mean_time))
    high = "∞" if math.isinf(found.high) else _digits(found.high, unit)
    return f"{mean} {unit} ({low}–{high})"


def _unit(duration: float) -> str:
    """The largest unit in which a duration [s] is at least 1; for shorter ones the second."""
    return next((unit for unit in ("h", "min") if convert(duration, unit) >= 1.0), "s")


def _digits(duration: float, unit: str) -> str:
    return two_digits(convert(duration, unit))


def delay_cell(delay: Delay, watched: float) -> Cell:
    """A delay in s with its interval, such as ``2.3 (2.1–2.6)``; ``> 58``: longer than the record.

    Parameters
    ----------
    delay : Delay
    watched : float
        Time from the onset to the end of the record [s].
    """
    beyond = f"> {two_digits(watched)}"
    if math.isinf(delay.value):
        return Cell(beyond)
    high = beyond if math.isinf(delay.high) else two_digits(delay.high)
    return Cell(f"{two_digits(delay.value)} ({two_digits(delay.low)}–{high})", value=delay.value)


def between_alarms_cell(chart: ChartJudgement, population: Population) -> Cell:
    """The mean time between false alarms with its interval.

    Strong: shown to be shorter than the limit requires; ``?``: too few hours to tell.
    """
    found, keeps = chart.false_alarms.get(population), chart.keeps(population)
    if found is None:
        return Cell(HOLE)
    mark = " ?" if keeps is None else ""
    mean = None if math.isinf(found.mean_time) else hours(found.mean_time)
    return Cell(f"{mean_time_text(found)}{mark}", keeps is False, mean)
