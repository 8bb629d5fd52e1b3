"""Robust standardisation and whitening of features, and what is computed from them record by record."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.scores.contract import LEAST_RECORDS, Flags, Score, as_features
from hydrofdi.errors import ConfigError, NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.messages import counted

EXTRA = "pip install 'hydrofdi[learn]'"
"""Command that installs the extra."""


def has_extra() -> bool:
    """Whether the extra is installed."""
    try:
        with scikit_learn(""):
            return True
    except ConfigError:
        return False


@contextmanager
def scikit_learn(name: str) -> Iterator[None]:
    """Context for the use of scikit-learn by a score, including imports.

    Its linear algebra runs in one thread: then results do not depend on the number of cores, and
    oversubscribed threads do not slow it down twentyfold.

    Parameters
    ----------
    name : str
        Name of the score.

    Raises
    ------
    ConfigError
        scikit-learn is not installed.
    """
    try:
        import sklearn  # noqa: F401
        from threadpoolctl import threadpool_limits
    except ModuleNotFoundError as error:
        if error.name not in ("sklearn", "threadpoolctl"):
            raise
        raise ConfigError(f"the score {name} needs the extra: {EXTRA}") from None
    with threadpool_limits(limits=1):
        yield


NORMAL_QUARTILES = 1.3489795003921634
"""Interquartile range of a normal distribution, in standard deviations."""

FAR = 5.0
"""Standardised values of fit records are limited to ± this value, so that outliers do not dominate a fit."""


def require_shape(array: NDArray[Any], *shape: int) -> None:
    """Check that an array of a trained rule fits the others.

    Raises
    ------
    ValueError
        It does not.
    """
    if array.shape != shape:
        raise ValueError(f"expected an array of the shape {shape}, not {array.shape}")


@dataclass(frozen=True, eq=False)
class Standardisation:
    """z = (x - median)/(interquartile range/1.349); the standard deviation if the quartiles are equal.

    Attributes
    ----------
    kept : ndarray of int, shape (n_kept,)
        Features that vary among the fit records. Constant features have no scale and are omitted.
    centre, scale : ndarray, shape (n_kept,)
    """

    kept: NDArray[np.intp]
    centre: Array
    scale: Array

    def __post_init__(self) -> None:
        """Check the shapes."""
        for array in (self.kept, self.centre, self.scale):
            require_shape(array, self.kept.size)
        if not (np.all(self.kept >= 0) and np.all(self.scale > 0.0)):
            raise ValueError("expected positions of features, and scales above 0")

    def __call__(self, values: Array) -> Array:
        """Standardised features, shape (n_record, n_kept)."""
        return np.ascontiguousarray((values[:, self.kept] - self.centre) / self.scale)

    def held(self, values: Array) -> Array:
        """Standardised features of fit records, limited to ±5."""
        return np.clip(self(values), -FAR, FAR)


def standardisation(values: Array) -> Standardisation:
    """Fit the standardisation to fit records.

    Parameters
    ----------
    values : ndarray, shape (n_fit, n_feature)

    Raises
    ------
    NotStatedError
        No feature varies.
    """
    low, centre, high = np.quantile(values, [0.25, 0.5, 0.75], axis=0)
    quartiles = (high - low) / NORMAL_QUARTILES
    rounding = 1e-12 * np.abs(values).max(axis=0)
    scale = np.where(quartiles > rounding, quartiles, values.std(axis=0))
    (kept,) = np.nonzero(scale > rounding)
    if not kept.size:
        raise NotStatedError("no feature varies among the fit records")
    return Standardisation(kept, centre[kept], scale[kept])


def healthy_scale(scores: ArrayLike) -> tuple[float, float]:
    """Median and spread of healthy scores of any shape; NaN values are ignored.

    Raises
    ------
    NotStatedError
        There are fewer than five scores, or all are equal.
    """
    known = np.ravel(np.asarray(scores, dtype=float))
    known = known[np.isfinite(known)]
    if known.size < LEAST_RECORDS:
        raise NotStatedError(
            f"a healthy scale needs {LEAST_RECORDS} healthy scores, not {known.size}", LEAST_RECORDS
        )
    scale = standardisation(known[:, None])
    return float(scale.centre[0]), float(scale.scale[0])


@dataclass(frozen=True, eq=False)
class LinearRule:
    """Weighted sum of the standardised features.

    Attributes
    ----------
    standardised : Standardisation
    weights : ndarray, shape (n_kept,)
    offset : float
    """

    standardised: Standardisation
    weights: Array
    offset: float

    def __post_init__(self) -> None:
        """Check the shape."""
        require_shape(self.weights, self.standardised.kept.size)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return self.offset + row_products(self.standardised(values), self.weights[:, None])[:, 0]


def row_products(rows: Array, matrix: Array) -> Array:
    """`rows` @ `matrix`, bit-identical per row: in BLAS the order of sums depends on the number of rows.

    Parameters
    ----------
    rows : ndarray, shape (n_record, n_feature)
        Contiguous.
    matrix : ndarray, shape (n_feature, n_column)
    """
    return np.stack([np.sum(rows * column, axis=1) for column in matrix.T], axis=1)


SHRINKAGES = np.logspace(-6, 0, 13)
"""Shrinkage values for the cross-validation."""


@dataclass(frozen=True, eq=False)
class Whitening:
    """Coordinates in which the fit records have mean 0 and a unit (shrunk) covariance.

    Attributes
    ----------
    standardised : Standardisation
    mean : ndarray, shape (n_kept,)
    matrix : ndarray, shape (n_kept, n_kept)
    """

    standardised: Standardisation
    mean: Array
    matrix: Array

    def __post_init__(self) -> None:
        """Check the shapes."""
        n_kept = self.standardised.kept.size
        require_shape(self.mean, n_kept)
        require_shape(self.matrix, n_kept, n_kept)

    def __call__(self, values: Array) -> Array:
        """Whitened features, shape (n_record, n_kept)."""
        return row_products(self.standardised(values) - self.mean, self.matrix)


def whitening(values: Array, name: str, shrinkage: float | None = None) -> Whitening:
    """Fit the whitening to fit records, with the covariance (1 - δ) S + δ tr(S)/n_kept I.

    Parameters
    ----------
    values : ndarray, shape (n_fit, n_feature)
    name : str
        Name of the score, for messages.
    shrinkage : float, optional
        δ; by default the value with the largest likelihood in five-fold cross-validation: Hoffbeck and
        Landgrebe, IEEE Trans. Pattern Anal. Mach. Intell. 18 (1996) 763. Ledoit-Wolf shrinkage is optimal for
        the covariance, not for its inverse: it masks deviations in directions in which healthy records hardly
        vary.

    Raises
    ------
    NotStatedError
        The covariance is singular: there are too few records for the features, and no shrinkage.
    """
    standardised = standardisation(values)
    held = standardised.held(values)
    with scikit_learn(name):
        variances, directions = np.linalg.eigh(_covariance(held, shrinkage))
    if variances[0] <= 1e-12 * variances[-1]:
        raise NotStatedError(
            f"the score {name} needs more than {counted(values.shape[0], 'record')}"
            f" for {counted(variances.size, 'feature')}"
            " that vary, fewer features, or shrinkage"
        )
    return Whitening(standardised, held.mean(axis=0), directions / np.sqrt(variances))


def _covariance(values: Array, shrinkage: float | None) -> Array:
    from sklearn.covariance import ShrunkCovariance
    from sklearn.model_selection import GridSearchCV, KFold

    if shrinkage is not None:
        return np.asarray(ShrunkCovariance(shrinkage=shrinkage).fit(values).covariance_)
    folds = KFold(LEAST_RECORDS, shuffle=True, random_state=0)
    search = GridSearchCV(ShrunkCovariance(), {"shrinkage": SHRINKAGES}, cv=folds)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Only one sample available")  # one record is enough
        return np.asarray(search.fit(values).best_estimator_.covariance_)


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
    if not features.shape[1]:
        raise NotStatedError("no number is measured in at least 90 % of the fit records")
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
