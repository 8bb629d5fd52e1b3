"""Evaluation and ranking of all scores of a study, and comparison of its designs."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.detectors.rules import Rules
from hydrofdi.detectors.scores.configuration import CHANGE
from hydrofdi.detectors.trained.configuration import stated_indicators
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import confidence_text, holm, simultaneous_confidence
from hydrofdi.evaluation.scores import Array, Kind, Population
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.studies.judging import judge
from hydrofdi.studies.reading import read_study, within
from hydrofdi.studies.records import Detection, Judgement, Scored, StudyRecords, pareto_set, ranked


def detect(records: StudyRecords, scores: Sequence[Scored], rules: Rules) -> Detection:
    """Evaluate all scores of a study.

    Top-ranked scores and scores in the Pareto set were selected among many, so they get a second bound,
    ``q90_95_of_all``, that is simultaneous for all scores.
    """
    judged = [judge(records, scored, rules) for scored in scores]
    judgements = ranked(judged, is_labelled=records.is_labelled)
    best = pareto_set(judgements)
    judgements = tuple(
        judge(records, each.scored, rules, n_tried=len(scores))
        if rank == 0 or each.scored.name in best
        else each
        for rank, each in enumerate(judgements)
    )
    return Detection(
        records, judgements, rules, best, (*records.remarks, *_remarks(records, len(scores), rules))
    )


def _remarks(records: StudyRecords, n_tried: int, rules: Rules) -> list[str]:
    remarks = []
    if n_tried > 1:
        together = simultaneous_confidence(rules.confidence, n_tried)
        remarks.append(
            f"{counted(n_tried, 'score')} were tried. The bounds apply to a"
            " score chosen in advance. If you pick the"
            f" best of {n_tried}, use the {confidence_text(together)} % bound (Bonferroni)"
        )
    if records.groups is not None:
        n_group = len(set(records.groups))
        remarks.append(
            f"{counted(n_group, 'group')}: intervals of rates allow for"
            " differences between groups, curves of detection"
            " do not"
        )
    if not records.chosen(Kind.FAULT, is_fit=False):
        remarks.append("no faulty record is tested: there are no results on detection")
    return remarks


def judge_study(data: ExperimentData) -> tuple[Detection, ...]:
    """Evaluate every score of every design of a stored study."""
    rules = data.experiment.detection
    return tuple(detect(design.records, design.scores, rules) for design in read_study(data))


def winner(detection: Detection, sensors: Collection[str] = ()) -> Judgement | None:
    """The best score that keeps its false-alarm rate, can be trained and needs no more than some sensors.

    Changes since an earlier record cannot be trained: a detector judges each record by itself.
    """
    for judgement in detection.judgements:
        scored = judgement.scored
        names = [scored.name] if scored.made_by is None else [*scored.made_by.of, *scored.made_by.by]
        is_change = any(name.endswith(CHANGE) for name in names)
        if judgement.keeps_its_rate and within(scored, sensors) and not is_change:
            return judgement
    return None


def detector_settings(experiment: ExperimentConfig, judgement: Judgement, rules: Rules) -> dict[str, Any]:
    """Keys of a detector that computes a judged score, with the threshold of the study."""
    made, scored = experiment.indicator_choice.made(experiment.wavelet), judgement.scored
    settings: dict[str, Any] = {
        "direction": str(judgement.direction),
        "false_alarm_rate": rules.false_alarm_rate,
        "confidence": rules.confidence,
        "threshold": rules.threshold,
        "chart": None,
        "compensate": False,
    }
    if scored.made_by is None:
        label, _, output = scored.name.partition(".")
        options = made[label].options.model_dump(mode="json")
        return settings | {"indicator": made[label].name, "options": options, "output": output}
    names = [*scored.made_by.of, *scored.made_by.by]
    used = dict.fromkeys(name.partition(".")[0] for name in names)
    indicators = stated_indicators({label: made[label] for label in used}, in_full=True)
    return settings | {"indicators": indicators, "score": scored.made_by.model_dump(mode="json")}


Counts = NDArray[np.int64]

N_DRAW = 400


@lru_cache(maxsize=4)
def redrawn(n_healthy: int, n_faulty: tuple[int, ...], seed: int = 0) -> tuple[Counts, Counts]:
    """How often each fit record, and each test record of each severity, is drawn with replacement."""
    draw = np.random.default_rng(seed)
    parts = [draw.multinomial(n, np.full(n, 1.0 / n), size=N_DRAW) for n in (n_healthy, *n_faulty)]
    return parts[0], np.hstack(parts[1:])


def _limits(healthy: Array, limit: float, counts: Counts) -> Array:
    """Upper limits of the same rank among resampled fit records, shape (n_draw,)."""
    if np.isinf(limit):
        return np.full(len(counts), limit)
    rank = int(np.sum(healthy >= limit))
    if not np.any(healthy == limit):
        raise NotStatedError("thresholds of a tail model cannot be resampled")
    order = np.argsort(-healthy)[: int(np.sum(~np.isnan(healthy)))]
    reached = np.cumsum(counts[:, order], axis=1) >= rank
    return np.asarray(healthy[order][reached.argmax(axis=1)])


@dataclass(frozen=True)
class Gain:
    """Difference in detection between two designs with the same actuators.

    Attributes
    ----------
    value, low, high : float
        Difference of the detection rates over all faulty test records, and its interval.
    p_value : float
        p-value of the null hypothesis of no difference.
    """

    value: float
    low: float
    high: float
    p_value: float
    confidence: float


@dataclass(frozen=True)
class EvaluatedScore:
    """An evaluated score of a design."""

    records: StudyRecords
    judgement: Judgement

    @cached_property
    def healthy(self) -> Array:
        """Scores of the healthy fit records."""
        return self.records.values(self.judgement.scored, self.records.chosen(Kind.HEALTHY, is_fit=True))

    @cached_property
    def faulty(self) -> Array:
        """Scores of the faulty test records."""
        return self.records.values(self.judgement.scored, [*self.n_record])

    @cached_property
    def n_record(self) -> dict[Population, int]:
        """Number of faulty test records of each severity."""
        return {each: self.records.rows(each).size for each in self.records.chosen(Kind.FAULT, is_fit=False)}

    @cached_property
    def detected(self) -> tuple[float, Array]:
        """Detection rate, and its values for resampled records, shape (n_draw,).

        Fit and test records are drawn, and thresholds have the same rank; a record without a score raises no
        alarm.
        """
        threshold, name = self.judgement.threshold, self.judgement.scored.name
        if threshold is None or not self.n_record:
            raise NotStatedError(f"{name} has no threshold, or there are no faults")
        faulty = self.faulty
        if np.isnan(faulty).all():
            raise NotStatedError("no faulty record has a score")
        counts, of_faulty = redrawn(self.healthy.size, tuple(self.n_record.values()))
        high = _limits(self.healthy, threshold.high, counts)
        low = -_limits(-self.healthy, -threshold.low, counts)
        is_alarm = (faulty > high[:, None]) | (faulty < low[:, None])
        hits = np.nan_to_num(threshold.outcomes(faulty), nan=0.0)
        return float(hits.mean()), np.asarray(np.sum(of_faulty * is_alarm, axis=1) / of_faulty.sum(axis=1))


def gain(reference: EvaluatedScore, other: EvaluatedScore, *, confidence: float = 0.95) -> Gain:
    """Paired difference of the detection rates of two designs, second minus first.

    Fit and test records are resampled, the same ones in both designs, and thresholds are set again, so that
    the interval includes the uncertainty of the thresholds. It is normal, with the standard deviation of the
    resamples.
    """
    from scipy.special import ndtr, ndtri

    if reference.n_record != other.n_record or reference.healthy.size != other.healthy.size:
        raise NotStatedError("designs must be compared on the same actuators, but their records differ")
    (before, drawn_before), (after, drawn_after) = reference.detected, other.detected
    value, deviation = after - before, float(np.std(drawn_after - drawn_before, ddof=1))
    p_value = 2.0 * float(ndtr(-abs(value) / deviation)) if deviation else math.nan
    spread = float(ndtri((1.0 + confidence) / 2.0)) * deviation
    return Gain(value, max(value - spread, -1.0), min(value + spread, 1.0), p_value, confidence)


def are_shown(compared: Sequence[Gain | None]) -> tuple[bool, ...]:
    """Whether each of several differences is significant after Holm's correction."""
    stated = [each for each in compared if each is not None]
    corrected = iter(holm([each.p_value for each in stated]).tolist())
    return tuple(each is not None and next(corrected) <= 1.0 - each.confidence for each in compared)
