"""Results of the evaluation of a control chart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from hydrofdi.detectors.run_lengths import AlarmLimit, Delay
from hydrofdi.evaluation.populations import Population
from hydrofdi.studies.records import StudyRecords


@dataclass(frozen=True)
class LeakDelay:
    """The detection delay of a leak of one nominal severity.

    Attributes
    ----------
    population : Population
    flow : float
        Mean of the true leakage flows from the onset on [m³/s].
    n_found, n : int
        Number of leaks detected before their record ends, and of all leaks.
    n_early : int
        Number of false alarms before the onset; the chart restarts after each.
    not_measurable : int
        Number of leaks whose estimator diverged before the onset; they count as not detected.
    watched : float
        Time from the latest onset to the last instant [s].
    median, late : Delay
        Delay within which half of the leaks, and the required fraction, are detected [s].
    """

    population: Population
    flow: float
    n_found: int
    n: int
    n_early: int
    not_measurable: int
    watched: float
    median: Delay
    late: Delay


@dataclass(frozen=True)
class ChartJudgement:
    """A chart at one limit.

    Attributes
    ----------
    label, watched, rule : str
        Label of the chart, the watched output, and the name of the chart rule.
    unit : str
        Unit of the watched output.
    false_alarm_every : float
        Required mean time between false alarms [s].
    centre, spread : float
        Median and spread of the watched output in healthy fit records [unit]; NaN if there is no limit.
    limit : AlarmLimit or None
        Limit set on healthy fit records; None if they do not support one.
    false_alarms : mapping of Population to AlarmLimit
        False alarms at this limit of healthy test records, each shift and each confusion.
    delays : tuple of LeakDelay
        Ascending in severity.
    refusals : tuple of str
        Results that are refused, and why.
    """

    label: str
    watched: str
    rule: str
    unit: str
    false_alarm_every: float
    centre: float = math.nan
    spread: float = math.nan
    limit: AlarmLimit | None = None
    false_alarms: Mapping[Population, AlarmLimit] = field(default_factory=dict)
    delays: tuple[LeakDelay, ...] = ()
    refusals: tuple[str, ...] = ()

    def keeps(self, population: Population) -> bool | None:
        """Whether the false-alarm rate of a population is compatible with the requirement.

        None if its records are not watched, or not long enough.
        """
        found = self.false_alarms.get(population)
        if found is None:
            return None
        if found.high < self.false_alarm_every:
            return False
        return True if found.duration >= time_needed(self.false_alarm_every, found.confidence) else None


@dataclass(frozen=True, eq=False)
class RunLengths:
    """The charts of a design of a study.

    Attributes
    ----------
    records : StudyRecords
    charts : tuple of ChartJudgement
        Evaluation of each chart at each limit.
    confidence : float
        Confidence level of all intervals.
    share : float
        Fraction of leaks for `LeakDelay.late`.
    """

    records: StudyRecords
    charts: tuple[ChartJudgement, ...]
    confidence: float
    share: float


def time_needed(false_alarm_every: float, confidence: float) -> float:
    """Alarm-free time that demonstrates a mean time between false alarms, in the same unit."""
    return -math.log(1.0 - confidence) * false_alarm_every
