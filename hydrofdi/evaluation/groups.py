"""Comparisons between groups of dependent records: units, days, directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.auc import Area, area_under_curve
from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.threshold import Threshold

Rule = Callable[[Array], Threshold]
"""Function that sets a threshold from healthy scores, such as a partial `tolerance_threshold`."""


@dataclass(frozen=True)
class HealthyPair:
    """Comparison of two healthy groups; without group differences there is no effect.

    Attributes
    ----------
    fit_group, test_group : str
    area : Area
        Area under the ROC curve of the test group against the fit group; 0.5 if they do not differ.
    rate : Rate or None
        False alarms of the test group at the threshold of the fit group; None if there is no threshold.
    refusal : str
        Why there is no rate.
    """

    fit_group: str
    test_group: str
    area: Area
    rate: Rate | None
    refusal: str = ""


def left_out_outcomes(healthy: ArrayLike, groups: Sequence[str], rule: Rule) -> Array:
    """Alarms of each group at the threshold of all others: cross-validation by group, Stone (1974).

    Journal of the Royal Statistical Society B 36, 111. `alarm_rate` with `groups` gives the rate of all.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
    groups : sequence of str, length n_record
    rule : callable

    Returns
    -------
    outcomes : ndarray, shape (n_record,)

    Raises
    ------
    NotStatedError
        There is only one group, or the others contain too few records for the rule.
    """
    scores, names = np.asarray(healthy, dtype=float), np.asarray(groups)
    distinct = np.unique(names)
    if distinct.size < 2:
        raise NotStatedError("leaving a group out needs two groups or more")
    outcomes = np.empty(scores.size)
    for name in distinct:
        outcomes[names == name] = rule(scores[names != name]).outcomes(scores[names == name])
    return outcomes


def healthy_against_healthy(
    healthy: ArrayLike, groups: Sequence[str], rule: Rule, *, confidence: float = 0.95
) -> tuple[HealthyPair, ...]:
    """Compare every healthy group with every other, as if the second were faulty.

    If the score separates healthy groups, separation elsewhere is not due to the fault alone. Pairs with a
    group without scores are omitted.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
    groups : sequence of str, length n_record
    rule : callable
    confidence : float
    """
    scores, names = np.asarray(healthy, dtype=float), np.asarray(groups)
    parts = {str(name): scores[names == name] for name in dict.fromkeys(groups)}
    known = [name for name, own in parts.items() if not np.all(np.isnan(own))]
    pairs = []
    for fit, test in permutations(known, 2):
        area = area_under_curve(parts[fit], parts[test], confidence=confidence)
        try:
            rate = alarm_rate(rule(parts[fit]).outcomes(parts[test]), confidence=confidence)
            pairs.append(HealthyPair(fit, test, area, rate))
        except NotStatedError as refusal:
            pairs.append(HealthyPair(fit, test, area, None, str(refusal)))
    return tuple(pairs)
