"""Scores of records by models that saw neither them nor their group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.contract import Flags, Score, as_features

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
    """Scores of records without separate fit and test: each by a model fitted on the other folds.

    Whole groups are dealt into folds; with `n_fold` groups or fewer, each is left out once (Stone, Journal of
    the Royal Statistical Society B 36 (1974) 111). Each fold has a model of its own; their scores are pooled.

    Parameters
    ----------
    score : Score
    values : array_like, shape (n_record, n_feature)
    is_faulty : array_like of bool, shape (n_record,)
    groups : sequence of str, length n_record, optional
        Units, days: what must not be split over fit and test. A record without one, ``""``, is one by itself.
    is_fit : array_like of bool, shape (n_record,), optional
        The records that may teach; all where it is not given. The others are only scored: by one model of all
        fit records, or by that of their fold where their group has fit records.
    n_fold : int
        Number of folds, 2 or more.
    seed : int
        Deals the groups into folds, healthy and faulty ones evenly.

    Returns
    -------
    scores : ndarray, shape (n_record,)
        NaN if a feature is not finite.

    Raises
    ------
    NotStatedError
        There is one group of fit records only, or a fold leaves too few of them.
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
    """The group of each record, counted from zero."""
    if groups is None:
        return np.arange(n_record)
    alone = [name or f"\0{record}" for record, name in enumerate(groups)]
    return np.unique(alone, return_inverse=True)[1]


def _folds(group: Numbers, is_faulty: Flags, teaches: Flags, n_fold: int, seed: int) -> Numbers:
    """The fold of each record: groups in drawn order, those with a fault last, dealt in turn.

    Groups that teach nothing are a fold by themselves, -1.
    """
    is_dealt = np.bincount(group, weights=teaches) > 0
    has_fault = np.bincount(group, weights=is_faulty & teaches) > 0
    drawn = np.random.default_rng(seed).permutation(np.flatnonzero(is_dealt))
    if drawn.size < 2:
        raise NotStatedError(
            "scores by models that did not see a record need two groups of fit records or more"
        )
    ordered = drawn[np.argsort(has_fault[drawn], kind="stable")]
    fold = np.full(is_dealt.size, -1)
    fold[ordered] = np.arange(drawn.size) % n_fold
    return fold[group]
