"""Area under the ROC curve of records in many groups, without resampling."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.auc import Area, area_under_curve, placements

MANY_GROUPS = 30
"""Minimum number of groups for a reliable estimate of the variance between groups."""


def clustered_area(
    healthy: ArrayLike,
    faulty: ArrayLike,
    healthy_groups: Sequence[str],
    faulty_groups: Sequence[str],
    *,
    confidence: float = 0.95,
) -> Area:
    """Area under the ROC curve, with an interval from the sums of DeLong's components in each group.

    Obuchowski, Biometrics 53 (1997) 567: a group may contain records of both kinds, such as those of one
    actuator before and after a fault. The interval is on the logit of the area; with perfect separation it is
    that of independent records.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
    healthy_groups, faulty_groups : sequence of str, length n_record
    confidence : float

    Raises
    ------
    NotStatedError
        There are fewer than thirty groups, or no scores of one kind.
    """
    from scipy.special import expit, logit, stdtrit

    area = area_under_curve(healthy, faulty, confidence=confidence)
    below, above = np.asarray(healthy, dtype=float), np.asarray(faulty, dtype=float)
    is_below, is_above = ~np.isnan(below), ~np.isnan(above)
    names = np.concatenate((np.asarray(healthy_groups)[is_below], np.asarray(faulty_groups)[is_above]))
    _, places = np.unique(names, return_inverse=True)
    n_group = int(places.max()) + 1
    if n_group < MANY_GROUPS:
        raise NotStatedError(f"the variance between groups needs {MANY_GROUPS} groups, not {n_group}")
    components = placements(below[is_below], above[is_above])
    departures = np.concatenate([(own - area.value) / own.size for own in components])
    sums = np.bincount(places, departures)
    deviation = math.sqrt(n_group / (n_group - 1) * float(np.sum(sums**2)))
    if not deviation:
        return area
    spread = stdtrit(n_group - 1, (1.0 + confidence) / 2.0) * deviation / (area.value * (1.0 - area.value))
    low, high = expit(logit(area.value) + np.array([-spread, spread]))
    return replace(area, low=float(low), high=float(high))
