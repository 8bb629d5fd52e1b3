"""Times, and times between alarms, as the words of a report."""

from __future__ import annotations

import math

from hydrofdi.detectors.run_lengths import Delay
from hydrofdi.evaluation.populations import Population
from hydrofdi.report.detection.wording import two_digits
from hydrofdi.report.document import Cell
from hydrofdi.report.wording import HOLE
from hydrofdi.studies.run_lengths.judgement import ChartJudgement
from hydrofdi.units import convert


def hours(duration: float) -> float:
    """A duration [s] in hours."""
    return convert(duration, "h")


def time_text(duration: float) -> str:
    """A duration [s] with its unit, such as ``24 h`` or ``2.5 min``."""
    for unit in ("h", "min"):
        if convert(duration, unit) >= 1.0:
            return f"{convert(duration, unit):.3g} {unit}"
    return f"{duration:.3g} s"


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
    """The mean time between false alarms in h with its interval, such as ``31 (12–110)``.

    Without an alarm it is the lower end of the interval, ``> 20``. Strong: shown to be shorter than the limit
    is set for; ``?``: too short a time to tell.
    """
    found, keeps = chart.false_alarms.get(population), chart.keeps(population)
    if found is None:
        return Cell(HOLE)
    mark = " ?" if keeps is None else ""
    least = two_digits(hours(found.low))
    if math.isinf(found.mean_time):
        return Cell(f"> {least}{mark}")
    most = "∞" if math.isinf(found.high) else two_digits(hours(found.high))
    mean = hours(found.mean_time)
    return Cell(f"{two_digits(mean)} ({least}–{most}){mark}", keeps is False, mean)
