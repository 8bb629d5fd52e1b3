"""Areas under the ROC curve of records in groups."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.roc import Area, area_under_curve, placements, share_below
from hydrofdi.evaluation.scores import Array

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


FEWEST_GROUPS = 5


def grouped_area(
    healthy: ArrayLike,
    faulty: ArrayLike,
    healthy_groups: Sequence[str],
    faulty_groups: Sequence[str],
    *,
    confidence: float = 0.95,
    n_draw: int = 2000,
    seed: int = 0,
) -> Area:
    """Area under the ROC curve, with an interval from resampled groups; a group may contain both kinds.

    Davison and Hinkley, Bootstrap Methods and their Application (1997), section 3.8; percentiles are widened
    for few groups after Hesterberg, The American Statistician 69 (2015) 371. Pairwise wins between groups are
    counted once, so resampling needs no sorting.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
    healthy_groups, faulty_groups : sequence of str, length n_record
    confidence : float
    n_draw : int
    seed : int

    Raises
    ------
    NotStatedError
        There are fewer than five groups, or no scores of one kind.
    """
    area = area_under_curve(healthy, faulty, confidence=confidence)
    below, above = np.asarray(healthy, dtype=float), np.asarray(faulty, dtype=float)
    is_below, is_above = ~np.isnan(below), ~np.isnan(above)
    order = np.flatnonzero(is_above)[np.argsort(above[is_above])]
    names = np.concatenate((np.asarray(healthy_groups)[is_below], np.asarray(faulty_groups)[order]))
    below, above = below[is_below], above[order]
    _, places = np.unique(names, return_inverse=True)
    n_group = int(places.max()) + 1
    if n_group < FEWEST_GROUPS:
        raise NotStatedError(f"an interval over groups needs {FEWEST_GROUPS} groups, not {n_group}")
    mine, theirs = places[: below.size], places[below.size :]
    sizes, others = np.bincount(mine, minlength=n_group), np.bincount(theirs, minlength=n_group)
    wins = np.zeros((n_group, n_group))
    for group in np.flatnonzero(sizes):
        share = share_below(below[mine == group], above)
        wins[group] = sizes[group] * np.bincount(theirs, share, minlength=n_group)
    counts = np.random.default_rng(seed).multinomial(n_group, np.full(n_group, 1.0 / n_group), size=n_draw)
    pairs = (counts @ sizes) * (counts @ others)
    drawn = np.einsum("bi,ij,bj->b", counts, wins, counts, optimize=True)[pairs > 0] / pairs[pairs > 0]
    low, high = _percentiles(drawn, n_group, confidence)
    return replace(area, low=low, high=high)


def _percentiles(values: Array, n_group: int, confidence: float) -> tuple[float, float]:
    from scipy.special import ndtr, stdtrit

    wide = math.sqrt(n_group / (n_group - 1)) * stdtrit(n_group - 1, (1.0 + confidence) / 2.0)
    low, high = np.quantile(values, [ndtr(-wide), ndtr(wide)])
    return float(low), float(high)
