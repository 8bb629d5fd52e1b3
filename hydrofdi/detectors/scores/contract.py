"""Interface of a score."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, ClassVar, TypeVar, cast, get_args, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.registry import Method
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, Direction
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import Section

Flags = NDArray[np.bool_]

Rule = Callable[[Array], Array]
"""Finite features (n_record, n_feature) → scores (n_record,), computed per record."""

Chosen = TypeVar("Chosen", bound=Section)

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
"""Minimum number of healthy fit records, and of faulty ones if needed."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A trained score.

    Attributes
    ----------
    rule : callable
        Rule for records that have all features.
    n_feature : int
    n_healthy, n_faulty : int
        Number of fit records.
    """

    rule: Rule
    n_feature: int
    n_healthy: int
    n_faulty: int

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
        features = as_features(values)
        if features.shape[1] != self.n_feature:
            raise ValueError(f"fitted on {counted(self.n_feature, 'feature')}, not on {features.shape[1]}")
        measured = np.isfinite(features).all(axis=1)
        scores = np.full(features.shape[0], np.nan)
        scores[measured] = self.rule(features[measured])
        return scores


class Score(Method[Chosen]):
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
    """

    needs_faulty: ClassVar[bool] = False
    needs_extra: ClassVar[bool] = True
    Trained: ClassVar[type[Any]]
    direction: ClassVar[Direction | None] = Direction.RISING

    def fit(self, values: ArrayLike, is_faulty: ArrayLike) -> Fitted:
        """Train the score on fit records; records with a missing feature are ignored.

        Parameters
        ----------
        values : array_like, shape (n_fit, n_feature)
        is_faulty : array_like of bool, shape (n_fit,)

        Raises
        ------
        NotStatedError
            There are too few records of a class, or they do not determine the score.
        ConfigError
            The score needs an extra that is not installed.
        """
        features, faulty = as_features(values), np.asarray(is_faulty, dtype=bool)
        used = np.isfinite(features).all(axis=1) & (self.needs_faulty | ~faulty)
        features, faulty = features[used], faulty[used]
        n_faulty = int(faulty.sum())
        n_healthy = faulty.size - n_faulty
        for kind, count in (("healthy", n_healthy), *([("faulty", n_faulty)] if self.needs_faulty else [])):
            if count < LEAST_RECORDS:
                raise NotStatedError(
                    f"the score {self.name} needs {LEAST_RECORDS} {kind} fit records that have all features,"
                    f" not {count}",
                    LEAST_RECORDS,
                )
        return Fitted(self.learn(features, faulty), features.shape[1], n_healthy, n_faulty)

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Train the rule on fit records.

        Parameters
        ----------
        values : ndarray, shape (n_fit, n_feature)
            Finite features; only of healthy records unless the score needs faulty ones.
        is_faulty : ndarray of bool, shape (n_fit,)
        """
        raise NotImplementedError


def as_features(values: ArrayLike) -> Array:
    """Features as an array of shape (n_record, n_feature) with contiguous rows.

    Raises
    ------
    ValueError
        The array does not have two dimensions.
    """
    features = np.ascontiguousarray(values, dtype=float)
    if features.ndim != 2:
        raise ValueError(f"features must have the shape (n_record, n_feature), not {features.shape}")
    return features


Made = TypeVar("Made")


def plain_data(rule: Any) -> dict[str, Any]:
    """A dataclass of arrays, numbers and such dataclasses as plain data for JSON."""
    found = {field.name: getattr(rule, field.name) for field in fields(rule)}
    return {
        name: plain_data(value) if is_dataclass(value) else np.asarray(value).tolist()
        for name, value in found.items()
    }


def from_data(kind: type[Made], data: Any, where: str = "") -> Made:
    """The dataclass that plain data describe.

    Raises
    ------
    ValueError
        A key is missing or unknown, a number is not finite, or shapes do not fit; the message starts with
        the key.
    """
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
