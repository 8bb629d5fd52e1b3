"""A feature minus its prediction from proxies, fitted to healthy records."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.contract import Flags, Rule, Score
from hydrofdi.scoring.rules import row_products
from hydrofdi.scoring.standardisation import FAR, Standardisation, standardisation
from hydrofdi.settings.quantities import Section

RECORDS_PER_COEFFICIENT = 2
"""Healthy records that each coefficient of the regression needs."""


class Compensated(Score[Section]):
    """The first feature minus its quadratic regression on the others, fitted on healthy records only.

    Beyond the range of the fit records a proxy counts as at its end: from there on a shift stays in the
    score, and no quadratic runs away with it. Fit records with a standardised feature beyond ±5 teach
    nothing.
    """

    name = "compensated"
    summary = "The first feature less its quadratic regression on the others, learned in healthy records."
    source = "Worden, Sohn and Farrar, J. Sound Vib. 258 (2002) 741, on novelty under varying surroundings"
    equation = (
        "y − Σ b_jk p_j p_k, p_0 = 1, p_j the proxies within the range of the fit records, b by least squares"
    )
    caution = (
        "It removes what the proxies tell and no more. Where few things vary, the proxies tell all of them,"
        " and leaks are found that are lost where more varies: believe it where everything varies that varies"
        " at the machine. Of a leak that moves a proxy, a part is compensated too. Beyond the range of the"
        " fit records a proxy counts as at its end, so that a shift is compensated up to there."
    )
    needs_faulty = False
    direction = None

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Least squares over healthy records."""
        if values.shape[1] < 2:
            raise NotStatedError("the score compensated needs a feature and one proxy or more")
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


@dataclass(frozen=True, eq=False)
class Residual:
    """What is left of the first feature, in its own unit.

    Attributes
    ----------
    standardised : Standardisation
    low, high : ndarray, shape (n_proxy,)
        Range of the proxies in the fit records, standardised.
    coefficients : ndarray, shape (n_term,)
    """

    standardised: Standardisation
    low: Array
    high: Array
    coefficients: Array

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        features = self.standardised(values)
        terms = quadratic_terms(np.clip(features[:, 1:], self.low, self.high))
        expected = row_products(terms, self.coefficients[:, None])[:, 0]
        return np.asarray((features[:, 0] - expected) * self.standardised.scale[0])


def quadratic_terms(proxies: Array) -> Array:
    """1, p_j and p_j p_k for j ≤ k.

    Parameters
    ----------
    proxies : ndarray, shape (n_record, n_proxy)

    Returns
    -------
    terms : ndarray, shape (n_record, (n_proxy + 1) (n_proxy + 2)/2)
    """
    columns = [np.ones(proxies.shape[0]), *proxies.T]
    return np.stack([first * second for first, second in combinations_with_replacement(columns, 2)], axis=1)
