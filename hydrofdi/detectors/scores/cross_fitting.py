"""Cross-fitted scores: the model of a record is not trained on its group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.scores.contract import Flags, Score, as_features
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array

Numbers = NDArray[np.intp]


def cross_fitted_scores(
    score: Score[Any],
    values: ArrayLike,
    is_faulty: ArrayLike,
    groups: Sequence[str] | None = None,
    *,
    is_fit: ArrayLike | None = None,
    n_fold: int = 10,
    seed: int = 0,
) -> Array:
    """Scores by cross-fitting: each record is scored by a model fitted on the other folds.

    Folds consist of whole groups; with at most `n_fold` groups, each group is one fold (Stone, Journal of the
    Royal Statistical Society B 36 (1974) 111). Each fold has its own model; the scores are pooled.

    Parameters
    ----------
    score : Score
    values : array_like, shape (n_record, n_feature)
    is_faulty : array_like of bool, shape (n_record,)
    groups : sequence of str, length n_record, optional
        Units or days that must not be split between fit and test. A record without a group (``""``) is its
        own group.
    is_fit : array_like of bool, shape (n_record,), optional
        Records that may be used for training; by default all. The others are only scored: by the model of
        their fold if their group has fit records, else by a model of all fit records.
    n_fold : int
        Number of folds, 2 or more.
    seed : int
        Seed of the assignment of groups to folds, which balances healthy and faulty ones.

    Returns
    -------
    scores : ndarray, shape (n_record,)
        NaN if a feature is not finite.

    Raises
    ------
    NotStatedError
        There is only one group of fit records, or a fold leaves too few of them.
    """
    features, faulty = as_features(values), np.asarray(is_faulty, dtype=bool)
    teaches = np.ones(faulty.size, dtype=bool) if is_fit is None else np.asarray(is_fit, dtype=bool)
    fold = _folds(_group_numbers(groups, faulty.size), faulty, teaches, n_fold, seed)
    scores = np.empty(faulty.size)
    for number in np.unique(fold):
        held_out = fold == number
        fitted = score.fit(features[teaches & ~held_out], faulty[teaches & ~held_out])
        scores[held_out] = fitted.score(features[held_out])
    return scores


def _group_numbers(groups: Sequence[str] | None, n_record: int) -> Numbers:
    """Group index of each record, from zero."""
    if groups is None:
        return np.arange(n_record)
    alone = [name or f"\0{record}" for record, name in enumerate(groups)]
    return np.unique(alone, return_inverse=True)[1]


def _folds(group: Numbers, is_faulty: Flags, teaches: Flags, n_fold: int, seed: int) -> Numbers:
    """Fold of each record: groups in random order, faulty groups last, are assigned in turn.

    Groups without training records have fold -1.
    """
    is_dealt = np.bincount(group, weights=teaches) > 0
    has_fault = np.bincount(group, weights=is_faulty & teaches) > 0
    drawn = np.random.default_rng(seed).permutation(np.flatnonzero(is_dealt))
    if drawn.size < 2:
        raise NotStatedError("cross-fitted scores need at least two groups of fit records")
    ordered = drawn[np.argsort(has_fault[drawn], kind="stable")]
    fold = np.full(is_dealt.size, -1)
    fold[ordered] = np.arange(drawn.size) % n_fold
    return fold[group]


_MOST_MISSING = 0.1
"""Largest fraction of fit records without a number that a score still uses."""


def known_numbers(values: Array) -> list[int]:
    """Places of the numbers that at least nine in ten fit records have.

    Parameters
    ----------
    values : ndarray, shape (n_fit, n_number)
    """
    if not values.size:
        return [*range(values.shape[1])]
    missing = np.mean(~np.isfinite(values), axis=0)
    return np.flatnonzero(missing <= _MOST_MISSING).tolist()
