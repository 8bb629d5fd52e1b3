"""A feature minus its prediction from proxies, fitted to healthy records."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from hydrofdi.detectors.scores.contract import Flags, Rule, Score
from hydrofdi.detectors.scores.features import (
    FAR,
    Standardisation,
    require_shape,
    row_products,
    standardisation,
)
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import Section

RECORDS_PER_COEFFICIENT = 2
"""Minimum number of healthy records per regression coefficient."""


@dataclass(frozen=True, eq=False)
class Residual:
    """Residual of the first feature, in its own unit.

    Attributes
    ----------
    standardised : Standardisation
    low, high : ndarray, shape (n_proxy,)
        Range of the standardised proxies in the fit records.
    coefficients : ndarray, shape (n_term,)
    """

    standardised: Standardisation
    low: Array
    high: Array
    coefficients: Array

    def __post_init__(self) -> None:
        """Check the shapes."""
        n_feature = self.standardised.kept.size
        require_shape(self.low, n_feature - 1)
        require_shape(self.high, n_feature - 1)
        require_shape(self.coefficients, n_feature * (n_feature + 1) // 2)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        features = self.standardised(values)
        terms = quadratic_terms(np.clip(features[:, 1:], self.low, self.high))
        expected = row_products(terms, self.coefficients[:, None])[:, 0]
        return np.asarray((features[:, 0] - expected) * self.standardised.scale[0])


class Compensated(Score[Section]):
    """The first feature minus its quadratic regression on the others, fitted on healthy records only.

    Proxies are limited to the range of the fit records, so that the quadratic does not extrapolate; a shift
    beyond the range remains in the score. Fit records with a standardised feature beyond ±5 are not used.
    """

    name = "compensated"
    summary = "The first feature minus its quadratic regression on the others, fitted to healthy records."
    source = (
        "Worden, Sohn and Farrar, J. Sound Vib. 258 (2002) 741, on novelty detection under varying conditions"
    )
    equation = (
        "y − Σ b_jk p_j p_k, p_0 = 1, p_j the proxies within the range of the fit records, b by least squares"
    )
    caution = (
        "It removes only effects that the proxies explain. If few nuisances vary, the proxies explain all"
        " of them, and leaks are detected that would be missed otherwise: use records in which everything"
        " varies that varies on the machine. If a leak changes a proxy, part of its effect is also"
        " compensated. Proxies are limited to the range of the fit records, so a shift is compensated only"
        " within it."
    )
    needs_faulty = False
    Trained = Residual
    needs_extra = False
    direction = None

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Fit by least squares to healthy records."""
        if values.shape[1] < 2:
            raise NotStatedError("the score compensated needs a feature and at least one proxy")
        standardised = standardisation(values)
        if standardised.kept[0] != 0:
            raise NotStatedError("the score compensated: its feature does not vary among healthy fit records")
        features = standardised(values)
        features = features[np.abs(features).max(axis=1) <= FAR]
        target, proxies = features[:, 0], features[:, 1:]
        terms = quadratic_terms(proxies)
        needed = RECORDS_PER_COEFFICIENT * terms.shape[1]
        if target.size < needed:
            raise NotStatedError(
                f"the score compensated has {terms.shape[1]} coefficients and needs {needed} healthy fit"
                f" records that have all features, none beyond ±{FAR:g} standard deviations,"
                f" not {target.size}",
                needed,
            )
        coefficients = np.asarray(np.linalg.lstsq(terms, target, rcond=None)[0], dtype=float)
        return Residual(standardised, proxies.min(axis=0), proxies.max(axis=0), coefficients)


def quadratic_terms(proxies: Array) -> Array:
    """Terms 1, p_j and p_j p_k for j ≤ k.

    Parameters
    ----------
    proxies : ndarray, shape (n_record, n_proxy)

    Returns
    -------
    terms : ndarray, shape (n_record, (n_proxy + 1) (n_proxy + 2)/2)
    """
    columns = [np.ones(proxies.shape[0]), *proxies.T]
    return np.stack([first * second for first, second in combinations_with_replacement(columns, 2)], axis=1)
