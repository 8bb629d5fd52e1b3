"""Interface of a score, and what scores share: standardised and whitened features, cross-fitting."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass
from typing import Any, ClassVar, TypeVar, cast, get_args, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.rules import Method
from hydrofdi.errors import ConfigError, NotStatedError
from hydrofdi.evaluation.scores import Array, Direction, group_numbers
from hydrofdi.settings.messages import counted

Flags = NDArray[np.bool_]

FROM_HEALTHY = (
    "It is trained on healthy records only: any condition that is not in the fit records, such as"
    " stiffer oil or another machine, raises it like a leak. Its own fit records have too low scores:"
    " set thresholds on other healthy records, or on cross-fitted scores."
)

FROM_BOTH = (
    "It applies to the population that it was fitted on: if healthy plants vary in other ways, many may"
    " raise alarms. Fit it on records in which everything varies that varies on the machine, and check its"
    " false alarms on shifts and confusions. Set thresholds on healthy records that it was not fitted on,"
    " or on cross-fitted scores, and test no record of the fit."
)

LEAST_RECORDS = 5
"""Minimum number of healthy scores, and of the fit records of most scores."""


class Rule:
    """A trained score, which computes the score of each record by itself."""

    def __call__(self, values: Array) -> Array:
        """Finite features, shape (n_record, n_feature) → scores, shape (n_record,)."""
        raise NotImplementedError

    def score(self, values: ArrayLike) -> Array:
        """Scores of records; bit-identical whatever other records are scored with them.

        Parameters
        ----------
        values : array_like, shape (n_record, n_feature)

        Returns
        -------
        scores : ndarray, shape (n_record,)
            NaN if a feature is not finite.
        """
        features = np.ascontiguousarray(values, dtype=float)
        measured = np.isfinite(features).all(axis=1)
        scores = np.full(features.shape[0], np.nan)
        scores[measured] = self(features[measured])
        return scores


class Score(Method):
    """Interface of a score: one number from several features of a record.

    Subclasses implement `learn`.

    Attributes
    ----------
    needs_faulty, needs_extra : bool
        Whether it is also trained on faulty records; if not, it receives none. Whether scikit-learn fits it.
    Trained : type
        Class of its trained rule: a frozen dataclass of arrays, numbers and such dataclasses.
    direction : Direction or None
        Direction of change with a fault; None if it must be learned from fit records.
    least : int
        Minimum number of healthy fit records, and of faulty ones if needed.
    """

    least: ClassVar[int] = LEAST_RECORDS
    needs_faulty: ClassVar[bool] = False
    needs_extra: ClassVar[bool] = True
    Trained: ClassVar[type[Any]]
    direction: ClassVar[Direction | None] = Direction.RISING

    def fit(self, values: ArrayLike, is_faulty: ArrayLike) -> Rule:
        """Train the score on fit records; records with a missing feature are ignored.

        Parameters
        ----------
        values : array_like, shape (n_fit, n_feature)
        is_faulty : array_like of bool, shape (n_fit,)
        """
        features, faulty = np.ascontiguousarray(values, dtype=float), np.asarray(is_faulty, dtype=bool)
        used = np.isfinite(features).all(axis=1) & (self.needs_faulty | ~faulty)
        features, faulty = features[used], faulty[used]
        counts = {"healthy": np.sum(~faulty), "faulty": np.sum(faulty)}
        for kind, count in counts.items():
            if count < self.least and (kind == "healthy" or self.needs_faulty):
                raise NotStatedError(
                    f"the score {self.name} needs {self.least} {kind} fit records that have all features,"
                    f" not {count}",
                    self.least,
                )
        return self.learn(features, faulty)

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Train the rule on fit records.

        Parameters
        ----------
        values : ndarray, shape (n_fit, n_feature)
            Finite features; only of healthy records unless the score needs faulty ones.
        is_faulty : ndarray of bool, shape (n_fit,)
        """
        raise NotImplementedError


Made = TypeVar("Made")


def plain_data(rule: Any) -> dict[str, Any]:
    """A dataclass of arrays, numbers and such dataclasses as plain data for JSON."""
    return {
        name: plain_data(value) if is_dataclass(value) else np.asarray(value).tolist()
        for name, value in vars(rule).items()
    }


def from_data(kind: type[Made], data: Any, where: str = "") -> Made:
    """The dataclass that plain data describe."""
    hints: dict[str, Any] = get_type_hints(kind)
    if not isinstance(data, dict) or data.keys() != hints.keys():
        raise ValueError(f"{where or 'rule'}: expected the keys {', '.join(hints)}")
    made: dict[str, Any] = {}
    for name, hint in hints.items():
        path = f"{where}.{name}".strip(".")
        if is_dataclass(hint):
            made[name] = from_data(cast("type[Any]", hint), data[name], path)
            continue
        try:
            array = np.asarray(data[name])
        except ValueError:
            raise ValueError(f"{path}: expected rows of equal length") from None
        wanted = np.dtype(float if hint is float else get_args(get_args(hint)[1])[0])
        is_number = array.dtype.kind == "i" or array.dtype.kind == wanted.kind == "f"
        if not is_number or not np.isfinite(array).all() or (hint is float) != (array.ndim == 0):
            raise ValueError(f"{path}: expected {'a finite number' if hint is float else 'finite numbers'}")
        made[name] = float(array) if hint is float else array.astype(wanted)
    try:
        return kind(**made)
    except ValueError as error:
        raise ValueError(f"{where or 'rule'}: {error}") from None


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
    """Check that an array of a trained rule fits the others."""
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
    """Fit the standardisation to fit records."""
    low, centre, high = np.quantile(values, [0.25, 0.5, 0.75], axis=0)
    quartiles = (high - low) / NORMAL_QUARTILES
    # What varies by less is rounding, and has no scale.
    rounding = 1e-12 * np.abs(values).max(axis=0)
    scale = np.where(quartiles > rounding, quartiles, values.std(axis=0))
    (kept,) = np.nonzero(scale > rounding)
    if not kept.size:
        raise NotStatedError("no feature varies among the fit records")
    return Standardisation(kept, centre[kept], scale[kept])


def healthy_scale(scores: ArrayLike) -> tuple[float, float]:
    """Median and spread of healthy scores of any shape; NaN values are ignored."""
    known = np.ravel(np.asarray(scores, dtype=float))
    known = known[np.isfinite(known)]
    if known.size < LEAST_RECORDS:
        raise NotStatedError(
            f"a healthy scale needs {LEAST_RECORDS} healthy scores, not {known.size}", LEAST_RECORDS
        )
    scale = standardisation(known[:, None])
    return float(scale.centre[0]), float(scale.scale[0])


@dataclass(frozen=True, eq=False)
class LinearRule(Rule):
    """Weighted sum of the standardised features.

    Attributes
    ----------
    weights : ndarray, shape (n_kept,)
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
    """
    standardised = standardisation(values)
    held = standardised.held(values)
    with scikit_learn(name):
        variances, directions = np.linalg.eigh(_covariance(held, shrinkage))
    # A singular covariance would turn rounding into large distances.
    if variances[0] <= 1e-12 * variances[-1]:
        raise NotStatedError(
            f"the score {name} needs more than {counted(values.shape[0], 'record')}"
            f" for {counted(variances.size, 'feature')}"
            " that vary, fewer features, or shrinkage"
        )
    # Coordinates along the principal directions, each over its deviation.
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
    score: Score,
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
    """
    features, faulty = np.ascontiguousarray(values, dtype=float), np.asarray(is_faulty, dtype=bool)
    if not features.shape[1]:
        raise NotStatedError("no number is measured in at least 90 % of the fit records")
    teaches = np.ones(faulty.size, dtype=bool) if is_fit is None else np.asarray(is_fit, dtype=bool)
    group = np.arange(faulty.size) if groups is None else group_numbers(groups)
    fold = _folds(group, faulty, teaches, n_fold, seed)
    scores = np.empty(faulty.size)
    for number in np.unique(fold):
        held_out = fold == number
        fitted = score.fit(features[teaches & ~held_out], faulty[teaches & ~held_out])
        scores[held_out] = fitted.score(features[held_out])
    return scores


def _folds(group: Numbers, is_faulty: Flags, teaches: Flags, n_fold: int, seed: int) -> Numbers:
    """Fold of each record: groups in random order, faulty groups last, are assigned in turn.

    Groups without training records have fold -1.
    """
    is_dealt = np.bincount(group, weights=teaches) > 0
    has_fault = np.bincount(group, weights=is_faulty & teaches) > 0
    drawn = np.random.default_rng(seed).permutation(np.flatnonzero(is_dealt))
    if drawn.size < 2:
        raise NotStatedError("cross-fitted scores need at least two groups of fit records")
    # A stable sort keeps the random order within both kinds.
    ordered = drawn[np.argsort(has_fault[drawn], kind="stable")]
    fold = np.full(is_dealt.size, -1)
    fold[ordered] = np.arange(drawn.size) % n_fold
    return fold[group]


_MOST_MISSING = 0.1
"""Largest fraction of fit records without a number that a score still uses."""


def known_numbers(values: Array) -> list[int]:
    """Places of the numbers that at least nine in ten fit records have."""
    if not values.size:
        return [*range(values.shape[1])]
    missing = np.mean(~np.isfinite(values), axis=0)
    return np.flatnonzero(missing <= _MOST_MISSING).tolist()
