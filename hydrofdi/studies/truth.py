"""Evaluation of estimates with known truth: errors, and coverage of their intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from hydrofdi.evaluation.rates import alarm_rate
from hydrofdi.evaluation.scores import Array, Kind
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import BULK_MODULUS, LEAKAGE_COEFFICIENT
from hydrofdi.studies.records import StudyRecords
from hydrofdi.units import convert

TRUTHS = {"internal_coefficient": LEAKAGE_COEFFICIENT, "bulk_modulus": BULK_MODULUS}
"""Output of an indicator → variable of the file with the true value of each run."""

ERROR = "_error"
"""Suffix of the output that contains the stated standard deviation of an estimate."""

FAULTS = "faults"
"""Name of the combination of all leaking test records."""


REFERENCE_PRESSURE = 8e6
"""Pressure difference at which K_i is shown as a flow [Pa]."""


@dataclass(frozen=True, eq=False)
class Estimates:
    """Evaluated estimates of a design.

    Attributes
    ----------
    rows : tuple of dict
        For each estimate and population: mean error, standard deviation of the errors, root mean square of
        the stated deviations, and the share of records whose stated interval contains the true value.
    has_constant_leaks : bool
        Whether leaks exist from the start; leaks with a later onset are excluded.
    without_deviation : tuple of str
        Estimates without a stated standard deviation, which are not evaluated.
    """

    rows: tuple[dict[str, Any], ...]
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
    found, without = [], []
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
        found += [
            _row(label, quantity, population, error[rows], deviation[rows], confidence)
            for population, rows in populations.items()
        ]
    return Estimates(tuple(found), confidence, is_constant, tuple(without))


def _row(
    label: str, quantity: str, population: str, error: Array, stated: Array, confidence: float
) -> dict[str, Any]:
    known = np.isfinite(error) & np.isfinite(stated)
    width = NormalDist().inv_cdf(0.5 + confidence / 2.0)
    covered = alarm_rate(np.where(known, np.abs(error) <= width * stated, np.nan), confidence=confidence)
    own, deviations, n = error[known], stated[known], int(known.sum())
    numbers = {
        "mean_error": float(own.mean()) if n else None,
        "deviation": float(own.std(ddof=1)) if n > 1 else None,
        "stated_deviation": float(np.sqrt(np.mean(np.square(deviations)))) if n else None,
    }
    is_modulus = quantity == "bulk_modulus"
    unit = "percent" if is_modulus else "L_per_min"

    def shown(value: float) -> float:
        return 100.0 * value if is_modulus else convert(value * math.sqrt(REFERENCE_PRESSURE), "L/min")

    return {
        "indicator": label,
        "quantity": "bulk_modulus" if is_modulus else "leakage",
        "population": population,
        "n": n,
        "not_measurable": int((~known).sum()),
        **{f"{name}_{unit}": None if each is None else shown(each) for name, each in numbers.items()},
        "covered": covered.value if n else None,
        "covered_low": covered.low,
        "covered_high": covered.high,
    }
