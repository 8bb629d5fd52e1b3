"""Evaluation of estimates with known truth: errors, and coverage of their intervals."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.evaluation.scores import Array, Kind
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout.names import BULK_MODULUS, LEAKAGE_COEFFICIENT
from hydrofdi.studies.records import StudyRecords

TRUTHS = {"internal_coefficient": LEAKAGE_COEFFICIENT, "bulk_modulus": BULK_MODULUS}
"""Output of an indicator → variable of the file with the true value of each run."""

ERROR = "_error"
"""Suffix of the output that contains the stated standard deviation of an estimate."""

FAULTS = "faults"
"""Name of the combination of all leaking test records."""


@dataclass(frozen=True)
class EstimateJudgement:
    """Errors of an estimate in one population.

    Attributes
    ----------
    indicator, quantity : str
        Label of the indicator, and the name of the output.
    bias, deviation, stated : float
        Mean error, standard deviation of the errors, and RMS of the stated standard deviations, in SI; for
        the bulk modulus relative to the true value.
    covered : Rate
        Coverage: fraction of records whose stated interval contains the true value.
    """

    indicator: str
    quantity: str
    population: str
    n: int
    not_measurable: int
    bias: float
    deviation: float
    stated: float
    covered: Rate


@dataclass(frozen=True, eq=False)
class Estimates:
    """Evaluated estimates of a design.

    Attributes
    ----------
    has_constant_leaks : bool
        Whether leaks exist from the start; leaks with a later onset are excluded.
    without_deviation : tuple of str
        Estimates without a stated standard deviation, which are not evaluated.
    """

    judgements: tuple[EstimateJudgement, ...]
    confidence: float
    has_constant_leaks: bool = True
    without_deviation: tuple[str, ...] = ()


def judge_estimates(data: ExperimentData, records: StudyRecords) -> Estimates:
    """Evaluate every estimate of a design of a stored study, on test records and shifts.

    Leaks with a later onset are excluded, and so is β if it is not constant: such records have no single true
    value.
    """
    confidence = data.experiment.detection.confidence
    is_constant = data.experiment.leakage.onset == "constant"
    populations = {
        each.name: records.rows(each)
        for kind in (Kind.HEALTHY, Kind.SHIFT)
        for each in records.chosen(kind, is_fit=False)
    }
    if is_constant and (faults := records.chosen(Kind.FAULT, is_fit=False)):
        populations[FAULTS] = np.sort(np.concatenate([*map(records.rows, faults)]))
    judged, without = [], []
    for name in data.columns:
        label, _, quantity = name.rpartition(".")
        has_truth = quantity == "internal_coefficient" or data.experiment.fluid.is_constant
        if not label or quantity not in TRUTHS or not has_truth:
            continue
        if (stated := data.columns.get(f"{name}{ERROR}")) is None:
            without.append(name)
            continue
        columns = (data.columns[TRUTHS[quantity]], data.columns[name], stated)
        truth, estimate, deviation = (np.asarray(own[records.runs], dtype=float) for own in columns)
        scale = truth if quantity == "bulk_modulus" else np.ones_like(truth)
        error, deviation = (estimate - truth) / scale, deviation / scale
        judged += [
            _judgement(label, quantity, population, error[rows], deviation[rows], confidence)
            for population, rows in populations.items()
        ]
    return Estimates(tuple(judged), confidence, is_constant, tuple(without))


def _judgement(
    label: str, quantity: str, population: str, error: Array, stated: Array, confidence: float
) -> EstimateJudgement:
    known = np.isfinite(error) & np.isfinite(stated)
    width = NormalDist().inv_cdf(0.5 + confidence / 2.0)
    holds = np.where(known, np.abs(error) <= width * stated, np.nan)
    own, deviations, n = error[known], stated[known], int(known.sum())
    return EstimateJudgement(
        label,
        quantity,
        population,
        n,
        int((~known).sum()),
        float(own.mean()) if n else np.nan,
        float(own.std(ddof=1)) if n > 1 else np.nan,
        float(np.sqrt(np.mean(np.square(deviations)))) if n else np.nan,
        alarm_rate(holds, confidence=confidence),
    )
