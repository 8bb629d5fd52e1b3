"""What a score is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.counting import counted
from hydrofdi.settings.quantities import Section

Flags = NDArray[np.bool_]

Rule = Callable[[Array], Array]
"""Finite features (n_record, n_feature) → scores (n_record,), each record by itself."""

Chosen = TypeVar("Chosen", bound=Section)

LEAST_RECORDS = 5
"""Healthy records, and faulty ones where they are needed, below which nothing is learned."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A score that has learned.

    Attributes
    ----------
    rule : callable
        The score of records that have all features.
    n_feature : int
    n_healthy, n_faulty : int
        Number of records that it rests on.
    """

    rule: Rule
    n_feature: int
    n_healthy: int
    n_faulty: int

    def score(self, values: ArrayLike) -> Array:
        """Scores of records, to the bit whatever other records are scored with them.

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


class Score(Protocol[Chosen]):
    """One number from several features of a record. Subclass it and implement its training.

    Attributes
    ----------
    name : str
        Name in files and on the command line; that of its module.
    summary : str
        What it tells, in one sentence.
    source : str
        Where it was published.
    equation : str
        Its definition, in one line.
    caution : str
        What has to be known before its numbers are believed.
    needs_faulty : bool
        Whether it learns from faulty records too; without, it sees none of them.
    direction : Direction or None
        The direction in which it departs from health; None if fit records have to show it.
    Options : type of Section
        Model of its options; it is valid without any.
    options : Section
        Its options.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    source: ClassVar[str]
    equation: ClassVar[str]
    caution: ClassVar[str]
    needs_faulty: ClassVar[bool]
    direction: ClassVar[Direction | None] = Direction.RISING
    Options: ClassVar[type[Section]] = Section
    options: Chosen

    def __init__(self, options: Chosen | None = None) -> None:
        chosen: Any = self.Options() if options is None else options
        self.options = chosen

    def fit(self, values: ArrayLike, is_faulty: ArrayLike) -> Fitted:
        """The score trained on fit records; records with a missing feature are ignored.

        Parameters
        ----------
        values : array_like, shape (n_fit, n_feature)
        is_faulty : array_like of bool, shape (n_fit,)

        Raises
        ------
        NotStatedError
            There are too few records of a kind, or they do not carry the score.
        ConfigError
            It needs an extra that is not installed.
        """
        features, faulty = as_features(values), np.asarray(is_faulty, dtype=bool)
        used = np.isfinite(features).all(axis=1) & (self.needs_faulty | ~faulty)
        features, faulty = features[used], faulty[used]
        n_faulty = int(faulty.sum())
        n_healthy = faulty.size - n_faulty
        self._refuse_few("healthy", n_healthy)
        if self.needs_faulty:
            self._refuse_few("faulty", n_faulty)
        return Fitted(self.learn(features, faulty), features.shape[1], n_healthy, n_faulty)

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """The rule that fit records teach.

        Parameters
        ----------
        values : ndarray, shape (n_fit, n_feature)
            Finite; of healthy records alone, unless it needs faulty ones.
        is_faulty : ndarray of bool, shape (n_fit,)
        """
        ...

    def _refuse_few(self, kind: str, count: int) -> None:
        if count < LEAST_RECORDS:
            raise NotStatedError(
                f"the score {self.name} needs {LEAST_RECORDS} {kind} fit records that have all features,"
                f" not {count}",
                LEAST_RECORDS,
            )


def as_features(values: ArrayLike) -> Array:
    """Features as an array of shape (n_record, n_feature), rows contiguous.

    Raises
    ------
    ValueError
        The array has another number of dimensions.
    """
    features = np.ascontiguousarray(values, dtype=float)
    if features.ndim != 2:
        raise ValueError(f"features have the shape (n_record, n_feature), not {features.shape}")
    return features
