"""Records of a study and parts of them, rules of their evaluation, and what is stated of each score."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.charts import AlarmLimit
from hydrofdi.detectors.rules import Rules, ScoreConfig
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation import pod
from hydrofdi.evaluation.rates import Area, HealthyPair, Rate, alarm_rate, confidence_text
from hydrofdi.evaluation.scores import NOTHING, Array, Direction, Estimate, Kind, Population, comparable
from hydrofdi.evaluation.threshold import Threshold, records_needed, time_needed


@dataclass(frozen=True)
class Scored:
    """Values of a score for every record.

    Attributes
    ----------
    name : str
        Name, such as ``ring_down.damping_ratio`` or ``dwt.detail_rms[2]``.
    values : ndarray, shape (n_record,)
        NaN if a record cannot be measured.
    channels : tuple of str
        Channels that it needs, in the order of `hydrofdi.records.Channel`.
    direction : Direction or None
        Direction of change that means a fault; None if it must be learned from fit records.
    cost : float or None
        CPU time per record [s]; None if it was not measured.
    note : str
        Issue on the score, such as how it was trained.
    made_by : ScoreConfig or None
        How it combines numbers; None if it is one.
    indicator : str
        Name of the indicator that measures it; empty if it combines several or is not measured here.
    """

    name: str
    values: Array
    channels: tuple[str, ...] = ()
    unit: str = "1"
    long_name: str = ""
    direction: Direction | None = None
    cost: float | None = None
    note: str = ""
    indicator: str = ""
    made_by: ScoreConfig | None = None

    @property
    def numbers(self) -> list[str]:
        """Names of the numbers that it combines; its own if it is one."""
        return [self.name] if self.made_by is None else [*self.made_by.of, *self.made_by.by]


@dataclass(frozen=True, eq=False)
class StudyRecords:
    """Records of one design of a study, simulated or measured.

    Attributes
    ----------
    of_record : ndarray of int, shape (n_record,)
        Index of the population of each record.
    severity : ndarray, shape (n_record,)
        True severity of the fault, such as the mean leakage flow of the record [unit of the severity]; 0
        without a fault, NaN if unknown.
    severity_unit : str
        SI.
    groups : tuple of str or None
        Group of each record; records of a group (a unit, a day) may be dependent. None if all are
        independent.
    design : mapping of str to object
        Settings common to all records, such as ``record.duration``: dotted parameter → value in SI.
    per_mean_flow : float
        Flow of the same leaks at `REFERENCE_DROP`, per mean leakage flow of the record: the median over the
        faulty records [-]; NaN if unknown.
    runs : ndarray of int, shape (n_record,)
        Rows of the records in the file of a stored study.
    is_labelled : bool
        Whether labels name the faults of measured records; otherwise their severities do.
    remarks : tuple of str
        Remarks on all rates of these records.
    """

    populations: tuple[Population, ...]
    of_record: NDArray[np.intp]
    severity: Array
    severity_unit: str = "m^3/s"
    groups: Sequence[str] | None = None
    design: Mapping[str, object] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    per_mean_flow: float = float("nan")
    is_labelled: bool = False
    runs: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, dtype=np.intp))

    def rows(self, population: Population) -> NDArray[np.intp]:
        """Rows of the records of a population."""
        return np.flatnonzero(self.of_record == self.populations.index(population))

    def values(self, scored: Scored, populations: Sequence[Population]) -> Array:
        """Scores of the records of some populations, one population after another."""
        rows = [self.rows(population) for population in populations]
        return scored.values[np.concatenate(rows)] if rows else np.empty(0)

    def n_missing(self, scored: Scored, population: Population) -> int:
        """Number of records of a population without a score."""
        return int(np.isnan(scored.values[self.rows(population)]).sum())

    def chosen(self, kind: Kind, *, is_fit: bool) -> tuple[Population, ...]:
        """Populations of a kind, ascending in severity."""
        own = (each for each in self.populations if each.kind is kind and each.is_fit is is_fit)
        return tuple(sorted(own, key=lambda each: each.severity))


@dataclass(frozen=True, eq=False)
class StudyDesign:
    """A design of a study with its scores; that of a measured study is its only one."""

    records: StudyRecords
    scores: tuple[Scored, ...]


@dataclass(frozen=True)
class Level:
    """Faulty test records of one nominal severity.

    Attributes
    ----------
    severity : float
        Mean true severity of its records [unit of the severity]; NaN if unknown.
    detected : Rate or None
        Detection rate; None without a threshold or a measured false-alarm rate.
    area : Area or None
        Area under the ROC curve against the healthy test records; None if undefined.
    """

    population: Population
    severity: float
    detected: Rate | None
    area: Area | None


LEAST_OF_GROUP = 5
"""Records of a healthy group that can be compared with another; areas of fewer are 0 or 1 by chance."""


@dataclass(frozen=True)
class Judgement:
    """Evaluation of a score as a detector, at the threshold set by healthy fit records.

    Attributes
    ----------
    direction : Direction
        Direction, declared or learned from fit records.
    threshold : Threshold or None
        None if the fit records do not carry one.
    false_alarms : mapping of Population to Rate
        False-alarm rates of healthy test records, each shift and each confusion; empty without a threshold.
    levels : tuple of Level
        Ascending.
    lack_of_fit : float
        P-value of the curve; NaN without one.
    smallest : mapping of str to DetectableSeverity
        ``q50``, ``q90`` (estimates at 50 % and at the required probability), ``q90_95`` (bound with the
        required confidence) and, for scores selected among many, ``q90_95_of_all`` (simultaneous bound);
        refused values are absent.
    counted : mapping of Population to int
        Population with too few records for a rate (only its alarms are counted) → number of records that a
        rate needs.
    refusals : tuple of str
        Results that are refused, and why.
    remarks : tuple of str
        Remarks on the results.
    bounding : tuple of PodCurve
        Curves for the bounds, the most likely first; all are compared with its likelihood.
    healthy_pairs : tuple of HealthyPair
        Every healthy group of labelled records against every other; empty if there are no two.
    """

    scored: Scored
    direction: Direction
    threshold: Threshold | None
    false_alarms: Mapping[Population, Rate]
    levels: tuple[Level, ...]
    curve: pod.PodCurve | None = None
    lack_of_fit: float = math.nan
    smallest: Mapping[str, pod.DetectableSeverity] = field(default_factory=dict)
    counted: Mapping[Population, int] = field(default_factory=dict)
    refusals: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    bounding: tuple[pod.PodCurve, ...] = ()
    healthy_pairs: tuple[HealthyPair, ...] = ()

    @property
    def keeps_its_rate(self) -> bool | None:
        """Whether healthy test records and shifts are compatible with the false-alarm rate of the threshold.

        They are if no lower limit of their rates exceeds the upper limit from the fit records. None if
        unknown: without a threshold or healthy test records, or if any of these populations has too few
        records for a rate. Confusions are not included: they have another fault, so their alarms are
        justified.
        """
        if self.threshold is None:
            return None
        tested = {each for each in self.false_alarms if each.kind is not Kind.CONFUSION}
        if tested & set(self.exceeded):
            return False
        is_known = any(each.kind is Kind.HEALTHY for each in tested) and not tested & self.counted.keys()
        return True if is_known else None

    @property
    def exceeded(self) -> tuple[Population, ...]:
        """Populations without the fault in which more alarm than the threshold allows."""
        if self.threshold is None:
            return ()
        allowed = self.threshold.interval[1]
        return tuple(each for each, rate in self.false_alarms.items() if rate.low > allowed)

    @property
    def middle_area(self) -> float:
        """Area under the ROC curve at the middle level; NaN if undefined."""
        areas = [level.area.value for level in self.levels if level.area is not None]
        return areas[(len(areas) - 1) // 2] if areas else math.nan

    @property
    def healthy_areas(self) -> list[float]:
        """Areas of healthy groups with enough records to be compared with each other."""
        pairs = (each.area for each in self.healthy_pairs)
        return [each.value for each in pairs if min(each.n_healthy, each.n_faulty) >= LEAST_OF_GROUP]

    @property
    def healthy_spread(self) -> float:
        """Largest distance of an area of healthy groups from 1/2; NaN if none can be compared."""
        return max((abs(area - 0.5) for area in self.healthy_areas), default=math.nan)

    @property
    def stands_clear(self) -> bool | None:
        """Whether the area of some fault lies further above 1/2 than healthy groups lie from it.

        None if unknown: without two healthy groups that can be compared.
        """
        if math.isnan(spread := self.healthy_spread):
            return None
        areas = [level.area.value - 0.5 for level in self.levels if level.area is not None]
        return bool(comparable(max(areas, default=0.0)) > comparable(spread))


@dataclass(frozen=True)
class LeakDelay:
    """The detection delay of a leak of one nominal severity.

    Attributes
    ----------
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
    median, late : Estimate
        Delay within which half of the leaks, and the required fraction, are detected [s].
    """

    population: Population
    flow: float
    n_found: int
    n: int
    n_early: int
    not_measurable: int
    watched: float
    median: Estimate
    late: Estimate


@dataclass(frozen=True)
class ChartJudgement:
    """A chart at one limit.

    Attributes
    ----------
    label, watched, rule : str
        Label of the chart, the watched output, and the name of the chart rule.
    centre, spread : float
        Median and spread of the watched output in healthy fit records [unit]; NaN if there is no limit.
    false_alarms : mapping of Population to AlarmLimit
        False alarms at this limit of healthy test records, each shift and each confusion.
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
        tested = self.false_alarms.get(population)
        if tested is None:
            return None
        if tested.high < self.false_alarm_every:
            return False
        return True if tested.duration >= time_needed(self.false_alarm_every, tested.confidence) else None


@dataclass(frozen=True, eq=False)
class Detection:
    """Evaluation of all scores of one design of a study.

    Attributes
    ----------
    pareto : frozenset of str
        Names of Pareto-optimal scores: no other score needs fewer channels and detects smaller faults at its
        false-alarm rate.
    remarks : tuple of str
        Remarks on all results, such as that the draws are not independent.
    charts : tuple of ChartJudgement
        Control charts on scores over time.
    """

    records: StudyRecords
    judgements: tuple[Judgement, ...]
    rules: Rules
    pareto: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
    charts: tuple[ChartJudgement, ...] = ()


_RANK_BY_RATE = {True: 0, None: 1, False: 2}


def ranked(judgements: Sequence[Judgement], *, is_labelled: bool = False) -> tuple[Judgement, ...]:
    """Rank scores by q90/95, best first; scores that exceed their false-alarm rate come last.

    Ties are resolved by fewer channels. Scores without a q90/95 are ranked by the detection rate at the
    largest level, then by the area at the middle level.

    A score that always alarms detects every leak, so scores that exceed their rate come last, after those for
    which this is unknown.

    Of labelled records, scores that stand clear of their healthy groups come first; of areas with the same
    two digits the one with the smaller healthy spread.
    """
    return tuple(sorted(judgements, key=_place_by_control if is_labelled else _place))


def _place(judgement: Judgement) -> tuple[int, float, float, float, str]:
    area, smallest = judgement.middle_area, comparable(found_from(judgement))
    suspicion = 0.0 if math.isnan(area) else comparable(area)
    second = float(len(judgement.scored.channels)) if math.isfinite(smallest) else -_largest_rate(judgement)
    kept = _RANK_BY_RATE[judgement.keeps_its_rate]
    return kept, smallest, second, -suspicion, judgement.scored.name


def _place_by_control(judgement: Judgement) -> tuple[bool, bool, float, float, float, str]:
    return (
        judgement.stands_clear is False,
        judgement.keeps_its_rate is False,
        comparable(found_from(judgement)),
        -round(0.0 if math.isnan(judgement.middle_area) else judgement.middle_area, 2),
        max(0.0, comparable(judgement.healthy_spread)),  # NaN counts as 0
        judgement.scored.name,
    )


def _largest_rate(judgement: Judgement) -> float:
    """Detection rate at the largest level; 0 if there is none."""
    rates = [level.detected.value for level in judgement.levels[-1:] if level.detected is not None]
    return rates[0] if rates and math.isfinite(rates[0]) else 0.0


def found_from(judgement: Judgement) -> float:
    """q90/95 [unit of the severity]; infinite if no tested severity is detected or it is refused."""
    bound = judgement.smallest.get("q90_95")
    value = None if bound is None else bound.value
    return math.inf if value is None else value


def pareto_set(judgements: Sequence[Judgement]) -> frozenset[str]:
    """Names of the Pareto-optimal scores in channels and q90/95.

    A score dominates another if its channels are a subset, its q90/95 is not larger, and one of the two is
    strictly better. Only scores that meet their false-alarm rate, have a q90/95 and declare their channels
    are included.
    """
    able = [
        (judgement.scored.name, frozenset(judgement.scored.channels), comparable(found_from(judgement)))
        for judgement in judgements
        if judgement.keeps_its_rate and judgement.scored.channels and math.isfinite(found_from(judgement))
    ]
    return frozenset(
        name
        for name, channels, smallest in able
        if not any(
            others <= channels and other <= smallest and (others < channels or other < smallest)
            for _, others, other in able
        )
    )


Stated = TypeVar("Stated")


@dataclass(frozen=True, eq=False)
class Part:
    """Scores of some records, in a reproducible order that does not depend on that of the records."""

    scores: Array
    severity: Array
    groups: list[str] | None

    @property
    def n_missing(self) -> int:
        """Number of records without a score."""
        return int(np.isnan(self.scores).sum())

    def rate(self, threshold: Threshold, confidence: float) -> Rate:
        """Alarm rate."""
        return alarm_rate(threshold.outcomes(self.scores), groups=self.groups, confidence=confidence)

    def detections(self, threshold: Threshold) -> Array:
        """1 if detected, 0 if not, shape (n_record,); a record without a score raises no alarm."""
        return np.nan_to_num(threshold.outcomes(self.scores), nan=0.0)

    def detected(self, threshold: Threshold, confidence: float) -> Rate:
        """Detection rate of faulty records; those without a score count as missed."""
        rate = alarm_rate(self.detections(threshold), groups=self.groups, confidence=confidence)
        return replace(rate, not_measurable=self.n_missing)


def part(records: StudyRecords, scored: Scored, populations: Collection[Population]) -> Part:
    """Scores of all records of some populations."""
    numbers = [records.populations.index(population) for population in populations]
    rows = np.flatnonzero(np.isin(records.of_record, numbers))
    rows = rows[np.lexsort((records.severity[rows], scored.values[rows]))]
    groups = None if records.groups is None else [records.groups[row] for row in rows.tolist()]
    return Part(scored.values[rows], records.severity[rows], groups)


SIGNIFICANCE = 0.05
"""Significance level of the goodness-of-fit test: a curve with a smaller p-value is not used."""


@dataclass(frozen=True, eq=False)
class TestedLevels:
    """Levels of nominal severity, ascending; all true severities are known.

    A record without a score raises no alarm, so it counts as a miss.
    """

    levels: Sequence[Part]
    threshold: Threshold

    @cached_property
    def severity(self) -> Array:
        """True severity of each record, shape (n_record,)."""
        return np.concatenate([level.severity for level in self.levels])

    @cached_property
    def outcomes(self) -> Array:
        """1 if detected, 0 if not, shape (n_record,)."""
        return np.concatenate([level.detections(self.threshold) for level in self.levels])

    @cached_property
    def tally(self) -> pod.Tally:
        """Hits of each level at its *largest* true severity.

        The probability of detection there is at least the mean of the level, so detectable severities are not
        too small.
        """
        rates = [level.detected(self.threshold, 0.95) for level in self.levels]
        hits, total = (
            np.array([getattr(rate, name) for rate in rates], float) for name in ("count", "total")
        )
        largest = [level.severity.max() for level in self.levels]
        return pod.Tally(np.maximum.accumulate(largest), hits, total)

    def lie_on_the_rise(self, curve: pod.PodCurve) -> bool:
        """Whether at least two levels lie on the slope of the curve.

        True severities within a level differ too little to determine a slope. A level whose severities span
        an octave counts as two.
        """
        if curve.is_step:
            return False
        floor, count = curve.false_alarm_rate, 0
        for level in self.levels:
            rise = (float(curve.probability(level.severity).mean()) - floor) / (1.0 - floor)
            span = level.severity.max() / level.severity.min()
            count += (1 + bool(comparable(span) >= 2.0)) * (0.01 < round(rise, 6) < 0.99)
        return count >= 2

    def curves(self, outcomes: Array, floor: float) -> list[pod.PodCurve]:
        """Curves on both axes, the more likely first; two levels have the same likelihood on both."""
        axes: tuple[pod.AxisName, ...] = ("log", "linear")
        log, linear = (
            pod.probability_of_detection(self.severity, outcomes, false_alarm_rate=floor, axis=axis)
            for axis in axes
        )
        return [log, linear] if log.log_likelihood >= linear.log_likelihood - 1e-6 else [linear, log]

    def curves_with_one_miss_more(self, floor: float) -> list[pod.PodCurve]:
        """Curves fitted with one detection fewer; none if these have no slope either.

        It is the one at the largest severity of the smallest level that is always detected. More hits never
        worsen a bound, so the bound of these curves is valid.
        """
        outcomes, first = self.outcomes.copy(), 0
        for level, misses in zip(self.levels, self.tally.misses, strict=True):
            if not misses:
                outcomes[first + int(np.argmax(level.severity))] = 0.0
                curves = self.curves(outcomes, floor)
                is_described = not pod.lack_of_fit(curves[0]) < SIGNIFICANCE
                return curves if is_described and self.lie_on_the_rise(curves[0]) else []
            first += level.severity.size
        return []

    def bound(self, probability: float, confidence: float) -> pod.DetectableSeverity:
        """Last level whose one-sided limit of the detection rate meets a probability."""
        rates = [level.detected(self.threshold, 2.0 * confidence - 1.0) for level in self.levels]
        shown = np.array([comparable(rate.low) >= comparable(probability) for rate in rates])
        n_group, needed = rates[-1].n_group, records_needed(1.0 - probability, confidence)
        if n_group is not None and n_group < needed and not shown[-1]:
            raise NotStatedError(
                f"{quantile_name(probability, confidence)} needs {needed} groups of faulty records that"
                f" agree; there are {n_group}",
                needed,
            )
        return pod.last_shown(self.tally.severity, shown, probability, confidence)


@dataclass
class Notes:
    """Remarks and refusals collected during an evaluation."""

    refusals: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def unless_refused(self, state: Callable[[], Stated]) -> Stated | None:
        """Result of `state`, or None if it is refused; the refusal is noted."""
        try:
            return state()
        except NotStatedError as refusal:
            self.refusals.append(str(refusal))
            return None


def quantile_name(probability: float, confidence: float) -> str:
    """Name such as ``q90/95``: detected with 90 % probability at 95 % confidence."""
    return f"q{100.0 * probability:.5g}/{confidence_text(confidence)}"


@dataclass(frozen=True)
class Nuisance:
    """Effect of one nuisance alone on a healthy score; None if there is no result.

    Attributes
    ----------
    parameter : str
        Dotted name; ``nothing`` for the variation between records of one actuator.
    alone : Spread or None
        Inner 90 % range of the score if only this nuisance varies, relative to the range if all vary.
    imitated : EquivalentFault or None
        As from `Response.imitated`.
    """

    parameter: str
    alone: pod.Spread | None
    imitated: pod.EquivalentFault | None


def nuisances_of(
    records: StudyRecords, scored: Scored, *, confidence: float = 0.95
) -> tuple[list[Nuisance], list[str]]:
    """Sensitivity of a score to each nuisance, the variation between records last, and what is refused."""
    notes = Notes()
    alone = sorted(records.chosen(Kind.ALONE, is_fit=False), key=lambda each: each.name == NOTHING)
    own = {each.name: records.values(scored, [each]) for each in alone}
    if not own:
        return [], []
    of_kind = [each for each in records.populations if each.kind is Kind.HEALTHY]
    healthy = records.values(scored, of_kind)
    faults = sorted(
        (_severity(records, each), index, records.values(scored, [each]))
        for index, each in enumerate(records.chosen(Kind.FAULT, is_fit=False))
    )
    response = None
    if faults:
        severity, _, scores = zip(*faults, strict=True)
        response = notes.unless_refused(
            lambda: pod.Response(healthy, scores, severity, confidence=confidence)
        )
    nuisances = []
    for name, values in own.items():
        spread = notes.unless_refused(partial(pod.relative_spread, values, healthy, confidence=confidence))
        imitated = None
        if response is not None:
            imitated = notes.unless_refused(partial(response.imitated, values, own[NOTHING]))
        nuisances.append(Nuisance(name, spread, imitated))
    return nuisances, [*dict.fromkeys(notes.refusals)]


def _severity(records: StudyRecords, population: Population) -> float:
    """Mean of the true severities; the nominal one if they are unknown."""
    known = records.severity[records.rows(population)]
    known = known[np.isfinite(known)]
    return float(known.mean()) if known.size else population.severity
