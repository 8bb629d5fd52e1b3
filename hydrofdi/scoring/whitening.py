"""Whitening of features: uncorrelated coordinates with equal variance."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.contract import LEAST_RECORDS
from hydrofdi.scoring.extra import scikit_learn
from hydrofdi.scoring.rules import row_products
from hydrofdi.scoring.standardisation import Standardisation, standardisation
from hydrofdi.settings.counting import counted

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
