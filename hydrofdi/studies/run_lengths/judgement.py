"""What is stated of a control chart."""

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
        Leaks that are found before their record ends, and all.
    n_early : int
        False alarms before the onset, after each of which the chart restarts.
    not_measurable : int
        Number of leaks whose estimator diverged before they set in; they count as not found.
    watched : float
        Time from the latest onset to the last instant [s].
    median, late : Delay
        Time from the onset to the alarm of half of the leaks, and of the stated share [s].
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
        What the chart is called, what it watches, and by which rule.
    unit : str
        Of what it watches.
    false_alarm_every : float
        Mean time between false alarms that the limit is set for [s].
    centre, spread : float
        Of what it watches, in healthy fit records [unit]; NaN if there is no limit.
    limit : AlarmLimit or None
        Set on healthy fit records; None if they do not carry one.
    false_alarms : mapping of Population to AlarmLimit
        What healthy test records, each shift and each confusion say of the same limit.
    delays : tuple of LeakDelay
        Ascending in severity.
    refusals : tuple of str
        What could not be stated, and why.
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
        """Whether records are not shown to alarm more often than the limit is set for.

        None if they are not watched long enough to tell, or not at all.
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
        Each chart at each limit.
    confidence : float
        Of every interval.
    share : float
        Of the leaks, in `LeakDelay.late`.
    """

    records: StudyRecords
    charts: tuple[ChartJudgement, ...]
    confidence: float
    share: float


def time_needed(false_alarm_every: float, confidence: float) -> float:
    """Time without an alarm that shows a mean time between false alarms [s], in the unit of that."""
    return -math.log(1.0 - confidence) * false_alarm_every
