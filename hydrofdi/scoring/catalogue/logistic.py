"""The log-odds of a fault."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.cautions import FROM_BOTH
from hydrofdi.scoring.contract import LEAST_RECORDS, Flags, Rule, Score
from hydrofdi.scoring.extra import scikit_learn
from hydrofdi.scoring.rules import LinearRule
from hydrofdi.scoring.standardisation import standardisation
from hydrofdi.settings.quantities import Section

STRENGTHS = np.logspace(-4, 2, 7)
"""Inverse strengths of the ridge among which fit records choose."""


class LogisticOptions(Section):
    """Options of `Logistic`."""

    seed: Annotated[int, Field(strict=True, ge=0, lt=2**32)] = 0
    """Deals the fit records into the folds by which the ridge is chosen."""


class Logistic(Score[LogisticOptions]):
    """Logistic regression with a ridge, chosen by the likelihood of five folds of the fit records."""

    name = "logistic"
    summary = "Log-odds of a fault by ridge logistic regression; fit records choose the ridge."
    source = "le Cessie and van Houwelingen, Applied Statistics 41 (1992) 191"
    equation = "b + wᵀ z, minimising Σ ln(1 + exp(−yᵢ (b + wᵀ zᵢ))) + ‖w‖²/(2 C)"
    caution = (
        f"{FROM_BOTH} The folds that choose the ridge divide records, not groups: where records of a group"
        " are alike, the ridge is too weak."
    )
    needs_faulty = True
    Options = LogisticOptions

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Weights at the ridge with the largest likelihood of records left out."""
        standardised = standardisation(values)
        with scikit_learn(self.name):
            from sklearn.linear_model import LogisticRegression
            from sklearn.model_selection import GridSearchCV, StratifiedKFold

            model = LogisticRegression(solver="newton-cholesky", max_iter=1000)
            folds = StratifiedKFold(LEAST_RECORDS, shuffle=True, random_state=self.options.seed)
            search = GridSearchCV(model, {"C": STRENGTHS}, scoring="neg_log_loss", cv=folds)
            best = search.fit(standardised.held(values), is_faulty).best_estimator_
        return LinearRule(standardised, best.coef_[0], float(best.intercept_[0]))
