"""Records of a study and parts of them, rules of their evaluation, and what is stated of each score."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.charts import AlarmLimit, Delays
from hydrofdi.detectors.rules import Rules, ScoreConfig
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation import pod
from hydrofdi.evaluation.rates import Area, HealthyPair, Rate, alarm_rate
from hydrofdi.evaluation.scores import NOTHING, Array, Direction, Kind, Population, comparable
from hydrofdi.evaluation.threshold import Threshold, time_needed


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

    def n_missing(self, scored: Scored, population: Population) -> int:
        """Number of records of a population without a score."""
        return int(np.isnan(scored.values[self.rows(population)]).sum())

    def chosen(self, kind: Kind, *, is_fit: bool) -> tuple[Population, ...]:
        """Populations of a kind, ascending in severity."""
        own = (each for each in self.populations if each.kind is kind and each.is_fit is is_fit)
        return tuple(sorted(own, key=lambda each: each.severity))


Found = TypeVar("Found", covariant=True)

SOUND = (Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION)
"""Kinds of populations whose alarms are false ones, in the order in which they are tested."""


@dataclass(frozen=True)
class Outcome(Generic[Found]):
    """What a score or a chart does on the test records of a population.

    Attributes
    ----------
    severity : float
        Mean true severity of its records [unit of the severity], of a delay the mean flow from the onset on
        [m³/s]; NaN if unknown.
    found : Rate, AlarmLimit, Delays or None
        Alarms of a score; false alarms of a chart, or its delays. None without a threshold or a measured
        false-alarm rate.
    area : Area or None
        Area under the ROC curve of leaks against the healthy test records; None if undefined.
    is_counted : bool
        Whether the records are too few for a rate, so that only its alarms are counted.
    """

    population: Population
    severity: float
    found: Found
    area: Area | None = None
    is_counted: bool = False


LEAST_OF_GROUP = 5
"""Records of a healthy group that can be compared with another; areas of fewer are 0 or 1 by chance."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """Evaluation of a score as a detector, at the threshold set by healthy fit records.

    Attributes
    ----------
    direction : Direction
        Direction, declared or learned from fit records.
    threshold : Threshold or None
        None if the fit records do not carry one.
    outcomes : tuple of Outcome
        Of healthy test records, shifts and confusions, none without a threshold; then of the levels of the
        fault, ascending.
    lack_of_fit : float
        P-value of the curve; NaN without one.
    smallest : mapping of str to DetectableSeverity
        ``q50``, ``q90`` (estimates at 50 % and at the required probability), ``q90_95`` (bound with the
        required confidence) and, for scores selected among many, ``q90_95_of_all`` (simultaneous bound);
        refused values are absent.
    refusals : tuple of str
        Results that are refused, and why.
    bounding : tuple of PodCurve
        Curves for the bounds, the most likely first; all are compared with its likelihood.
    healthy_pairs : tuple of HealthyPair
        Every healthy group of labelled records against every other; empty if there are no two.
    """

    scored: Scored
    direction: Direction
    threshold: Threshold | None
    outcomes: tuple[Outcome[Rate | None], ...]
    curve: pod.PodCurve | None = None
    lack_of_fit: float = math.nan
    smallest: Mapping[str, pod.DetectableSeverity] = field(default_factory=dict)
    refusals: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    bounding: tuple[pod.PodCurve, ...] = ()
    healthy_pairs: tuple[HealthyPair, ...] = ()

    @property
    def name(self) -> str:
        """Name of the score."""
        return self.scored.name

    @property
    def bound(self) -> pod.DetectableSeverity | None:
        """q90/95; None if it is refused."""
        return self.smallest.get("q90_95")

    @property
    def found_from(self) -> float:
        """q90/95 [unit of the severity]; infinite if no tested severity is detected or it is refused."""
        return math.inf if self.bound is None or self.bound.value is None else self.bound.value

    @property
    def finds(self) -> bool:
        """Whether a tested severity is found, whatever its false alarms are."""
        return math.isfinite(self.found_from)

    def of(self, population: Population) -> Outcome[Rate | None] | None:
        """Outcome of a population; None if it is not tested."""
        return next((each for each in self.outcomes if each.population == population), None)

    @property
    def levels(self) -> tuple[Outcome[Rate | None], ...]:
        """Outcomes of the fault, ascending."""
        return tuple(each for each in self.outcomes if each.population.kind is Kind.FAULT)

    @property
    def false_alarms(self) -> dict[Population, Rate]:
        """Rates of the populations without the fault."""
        pairs = ((each.population, each.found) for each in self.outcomes)
        return {one: rate for one, rate in pairs if one.kind is not Kind.FAULT and rate is not None}

    @property
    def keeps_its_rate(self) -> bool | None:
        """Whether healthy test records and shifts are compatible with the false-alarm rate of the threshold.

        They are if no lower limit of their rates exceeds the upper limit from the fit records. None if
        unknown: without a threshold or healthy test records, or if any of these populations has too few
        records for a rate. Confusions are not included: they have another fault, so their alarms are
        justified.
        """
        tested = [each for each in self.outcomes if each.population.kind in (Kind.HEALTHY, Kind.SHIFT)]
        if any(each.population in self.exceeded for each in tested):
            return False
        is_known = any(each.population.kind is Kind.HEALTHY for each in tested)
        return True if is_known and not any(each.is_counted for each in tested) else None

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
        areas = [each.area.value for each in self.outcomes if each.area is not None]
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
        areas = [each.area.value - 0.5 for each in self.outcomes if each.area is not None]
        return bool(comparable(max(areas, default=0.0)) > comparable(spread))


@dataclass(frozen=True)
class ChartJudgement:
    """A chart at one limit.

    Attributes
    ----------
    label, watched, rule : str
        Label of the chart, the watched output, and the name of the chart rule.
    centre, spread : float
        Median and spread of the watched output in healthy fit records [unit]; NaN if there is no limit.
    outcomes : tuple of Outcome
        False alarms at this limit of healthy test records, shifts and confusions; then delays of leaks.
    """

    label: str
    watched: str
    rule: str
    unit: str
    false_alarm_every: float
    centre: float = math.nan
    spread: float = math.nan
    limit: AlarmLimit | None = None
    outcomes: tuple[Outcome[AlarmLimit | Delays], ...] = ()
    refusals: tuple[str, ...] = ()

    @property
    def delays(self) -> dict[Population, Delays]:
        """Delays of the leaks that set in while the chart watches."""
        pairs = ((each.population, each.found) for each in self.outcomes)
        return {population: found for population, found in pairs if isinstance(found, Delays)}

    def keeps(self, tested: AlarmLimit) -> bool | None:
        """Whether the false alarms of a population are compatible with the requirement.

        None if its records are not long enough.
        """
        if tested.high < self.false_alarm_every:
            return False
        return True if tested.duration >= time_needed(self.false_alarm_every, tested.confidence) else None

    @property
    def kept(self) -> list[bool | None]:
        """`keeps` of each population without the fault."""
        return [self.keeps(each.found) for each in self.outcomes if isinstance(each.found, AlarmLimit)]


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
    area, smallest = judgement.middle_area, comparable(judgement.found_from)
    suspicion = 0.0 if math.isnan(area) else comparable(area)
    second = float(len(judgement.scored.channels)) if math.isfinite(smallest) else -_largest_rate(judgement)
    kept = _RANK_BY_RATE[judgement.keeps_its_rate]
    return kept, smallest, second, -suspicion, judgement.name


def _place_by_control(judgement: Judgement) -> tuple[bool, bool, float, float, float, str]:
    return (
        judgement.stands_clear is False,
        judgement.keeps_its_rate is False,
        comparable(judgement.found_from),
        -round(0.0 if math.isnan(judgement.middle_area) else judgement.middle_area, 2),
        max(0.0, comparable(judgement.healthy_spread)),  # NaN counts as 0
        judgement.name,
    )


def _largest_rate(judgement: Judgement) -> float:
    """Detection rate at the largest level; 0 if there is none."""
    rates = [level.found.value for level in judgement.levels[-1:] if level.found is not None]
    return rates[0] if rates and math.isfinite(rates[0]) else 0.0


def pareto_set(judgements: Sequence[Judgement]) -> frozenset[str]:
    """Names of the Pareto-optimal scores in channels and q90/95.

    A score dominates another if its channels are a subset, its q90/95 is not larger, and one of the two is
    strictly better. Only scores that meet their false-alarm rate, have a q90/95 and declare their channels
    are included.
    """
    able = [
        (judgement.name, frozenset(judgement.scored.channels), comparable(judgement.found_from))
        for judgement in judgements
        if judgement.keeps_its_rate and judgement.scored.channels and math.isfinite(judgement.found_from)
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


@dataclass(frozen=True)
class Nuisance:
    """Effect of one nuisance alone on a healthy score; None if there is no result.

    `parameter`: dotted name; ``nothing`` for the variation between records of one actuator. `alone`: inner
    90 % range of the score if only this nuisance varies, relative to the range if all vary. `imitated`: as
    from `Response.imitated`.
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
    own = {each.name: scored.values[records.rows(each)] for each in alone}
    if not own:
        return [], []
    healthy = np.concatenate(
        [scored.values[records.rows(each)] for each in records.populations if each.kind is Kind.HEALTHY]
    )
    faults = sorted(
        (_severity(records, each), index, scored.values[records.rows(each)])
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
