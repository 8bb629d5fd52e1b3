"""Log-odds of a fault by logistic regression."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.detectors.scores.contract import FROM_BOTH, LEAST_RECORDS, Flags, Rule, Score
from hydrofdi.detectors.scores.features import LinearRule, scikit_learn, standardisation
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import Section

STRENGTHS = np.logspace(-4, 2, 7)
"""Inverse ridge strengths for the cross-validation."""


class LogisticOptions(Section):
    """Options of `Logistic`."""

    seed: Annotated[int, Field(strict=True, ge=0, lt=2**32)] = 0
    """Seed of the folds for the choice of the ridge."""


class Logistic(Score[LogisticOptions]):
    """Logistic regression with a ridge penalty, chosen by five-fold cross-validation of the likelihood."""

    name = "logistic"
    summary = "Log-odds of a fault by ridge logistic regression; the ridge is chosen by cross-validation."
    source = "le Cessie and van Houwelingen, Applied Statistics 41 (1992) 191"
    equation = "b + wᵀ z, minimising Σ ln(1 + exp(−yᵢ (b + wᵀ zᵢ))) + ‖w‖²/(2 C)"
    caution = (
        f"{FROM_BOTH} The folds for the ridge divide records, not groups: if the records of a group"
        " are alike, the ridge is too weak."
    )
    needs_faulty = True
    Trained = LinearRule
    Options = LogisticOptions

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Fit weights with the ridge of largest cross-validated likelihood."""
        standardised = standardisation(values)
        with scikit_learn(self.name):
            from sklearn.linear_model import LogisticRegression
            from sklearn.model_selection import GridSearchCV, StratifiedKFold

            model = LogisticRegression(solver="newton-cholesky", max_iter=1000)
            folds = StratifiedKFold(LEAST_RECORDS, shuffle=True, random_state=self.options.seed)
            search = GridSearchCV(model, {"C": STRENGTHS}, scoring="neg_log_loss", cv=folds)
            best = search.fit(standardised.held(values), is_faulty).best_estimator_
        return LinearRule(standardised, best.coef_[0], float(best.intercept_[0]))
