"""Scores: distances from healthy records, discriminants of healthy and faulty ones, compensation."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.detectors.scores import contract
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import SI


@dataclass(frozen=True, eq=False)
class SquaredDistance(contract.Rule):
    """Squared distance from the mean after whitening."""

    white: contract.Whitening

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return np.asarray(np.sum(np.square(self.white(values)), axis=1))


class Mahalanobis(contract.Score):
    """Squared Mahalanobis distance from the mean of healthy records.

    (z − m)ᵀ C⁻¹ (z − m), C = (1 − δ) S + δ tr(S)/n I.

    Mahalanobis, Proc. Natl. Inst. Sci. India 2 (1936) 49; Hoffbeck and Landgrebe, IEEE Trans. Pattern
    Anal. Mach. Intell. 18 (1996) 763.
    """

    name = "mahalanobis"
    summary = "Squared Mahalanobis distance from healthy records, with a shrunk covariance."
    caution = contract.FROM_HEALTHY
    Trained = SquaredDistance

    shrinkage: Annotated[float, Field(ge=0, le=1)] | None = None
    """Weight δ of the identity matrix in the covariance; by default chosen by cross-validation on the fit
    records."""

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Fit mean and covariance of healthy records."""
        return SquaredDistance(contract.whitening(values, self.name, self.shrinkage))


@dataclass(frozen=True, eq=False)
class Outside(contract.Rule):
    """Distance from the boundary of a one-class support vector machine after whitening, positive outside.

    Attributes
    ----------
    vectors : ndarray, shape (n_vector, n_kept)
        Whitened support vectors.
    weights : ndarray, shape (n_vector,)
        Their coefficients α.
    gamma, offset : float
        1/(2 n b²), and ρ.
    """

    white: contract.Whitening
    vectors: Array
    weights: Array
    gamma: float
    offset: float

    def __post_init__(self) -> None:
        """Check the shapes."""
        contract.require_shape(self.vectors, self.weights.size, self.white.mean.size)
        contract.require_shape(self.weights, self.weights.size)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,); each record by itself."""
        # Differences do not cancel as products would, and their bits do not depend on other records.
        squared = (np.sum(np.square(self.vectors - row), axis=1) for row in self.white(values))
        near = [np.sum(self.weights * np.exp(-self.gamma * each)) for each in squared]
        return self.offset - np.array(near, dtype=float)


class OneClass(contract.Score):
    """One-class support vector machine on healthy records, with a Gaussian kernel on whitened features.

    ρ − Σᵢ αᵢ exp(−‖w − wᵢ‖²/(2 n b²)), w = C^(−1/2) (z − m), n features, b the width.

    Schölkopf et al., Neural Computation 13 (2001) 1443.
    """

    name = "one_class"
    summary = "One-class support vector machine around healthy records, on whitened features."
    caution = (
        f"{contract.FROM_HEALTHY} Records far away all have the score ρ: they raise alarms but cannot be"
        " ranked. The time of a fit grows with the square of the number of records."
    )
    Trained = Outside

    outside: Annotated[float, Field(gt=0, lt=1)] = 0.1
    """Largest fraction ν of the fit records outside the boundary."""

    width: Annotated[float, SI("1", above=0)] = 1.0
    """Width of the kernel, in RMS distances of healthy records from their mean."""

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Whiten by healthy records, then train the support vector machine."""
        white = contract.whitening(values, self.name)
        points = white(values)
        gamma = 0.5 / (points.shape[1] * self.width**2)
        with contract.scikit_learn(self.name):
            from sklearn.svm import OneClassSVM

            machine = OneClassSVM(kernel="rbf", gamma=gamma, nu=self.outside).fit(points)
        weights = machine.dual_coef_[0]
        return Outside(white, machine.support_vectors_, weights, gamma, float(machine.offset_[0]))


class Lda(contract.Score):
    """Linear discriminant with Ledoit-Wolf shrinkage of the covariance; both classes have equal weight.

    wᵀ (z − (m₀ + m₁)/2), w = C⁻¹ (m₁ − m₀), C the mean of the shrunk covariances of both kinds.

    Fisher, Annals of Eugenics 7 (1936) 179; Ledoit and Wolf, J. Multivar. Anal. 88 (2004) 365.
    """

    name = "lda"
    summary = "Linear discriminant of healthy and faulty records, with a shrunk covariance."
    caution = contract.FROM_BOTH
    needs_faulty = True
    Trained = contract.LinearRule

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Fit means and covariances of both classes."""
        standardised = contract.standardisation(values)
        with contract.scikit_learn(self.name):
            from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

            model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto", priors=[0.5, 0.5])
            model.fit(standardised.held(values), is_faulty)
        return contract.LinearRule(standardised, model.coef_[0], float(model.intercept_[0]))


STRENGTHS = np.logspace(-4, 2, 7)
"""Inverse ridge strengths for the cross-validation."""


class Logistic(contract.Score):
    """Logistic regression with a ridge penalty, chosen by five-fold cross-validation of the likelihood.

    b + wᵀ z, minimising Σ ln(1 + exp(−yᵢ (b + wᵀ zᵢ))) + ‖w‖²/(2 C).

    le Cessie and van Houwelingen, Applied Statistics 41 (1992) 191.
    """

    name = "logistic"
    summary = "Log-odds of a fault by ridge logistic regression; the ridge is chosen by cross-validation."
    caution = (
        f"{contract.FROM_BOTH} The folds for the ridge divide records, not groups: if the records of a group"
        " are alike, the ridge is too weak."
    )
    needs_faulty = True
    Trained = contract.LinearRule

    seed: Annotated[int, Field(strict=True, ge=0, lt=2**32)] = 0
    """Seed of the folds for the choice of the ridge."""

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Fit weights with the ridge of largest cross-validated likelihood."""
        standardised = contract.standardisation(values)
        with contract.scikit_learn(self.name):
            from sklearn.linear_model import LogisticRegression
            from sklearn.model_selection import GridSearchCV, StratifiedKFold

            model = LogisticRegression(solver="newton-cholesky", max_iter=1000)
            folds = StratifiedKFold(contract.LEAST_RECORDS, shuffle=True, random_state=self.seed)
            search = GridSearchCV(model, {"C": STRENGTHS}, scoring="neg_log_loss", cv=folds)
            best = search.fit(standardised.held(values), is_faulty).best_estimator_
        return contract.LinearRule(standardised, best.coef_[0], float(best.intercept_[0]))


@dataclass(frozen=True, eq=False)
class LargestFall(contract.Rule):
    """Largest fall below `means`, shape (n_feature,), relative to them."""

    means: Array

    def __post_init__(self) -> None:
        """Check the shape."""
        contract.require_shape(self.means, self.means.size)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return np.asarray(np.max((self.means - values) / self.means, axis=1))


class LargestChange(contract.Score):
    """Largest relative fall of a feature below its healthy mean.

    It scales features by their means, so it depends on their zero points, unlike the other scores.

    max_j (m_j − y_j)/m_j, m the means of healthy records.

    Maddahi, Yazdanpanah Goharrizi, Wu and Sepehri, CDSR 2015, paper 181.
    """

    name = "largest_change"
    summary = "Largest fall of a feature below its healthy mean, relative to the mean."
    caution = "The feature that varies most without a fault dominates: a change is scaled only by the mean."
    needs_extra = False
    Trained = LargestFall

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Fit the means of healthy records."""
        means = values.mean(axis=0)
        if not means.all():
            raise NotStatedError("the score largest_change: a feature has zero mean in healthy records")
        return LargestFall(means)


RECORDS_PER_COEFFICIENT = 2
"""Minimum number of healthy records per regression coefficient."""


@dataclass(frozen=True, eq=False)
class Residual(contract.Rule):
    """Residual of the first feature, in its own unit.

    Attributes
    ----------
    low, high : ndarray, shape (n_proxy,)
        Range of the standardised proxies in the fit records.
    coefficients : ndarray, shape (n_term,)
    """

    standardised: contract.Standardisation
    low: Array
    high: Array
    coefficients: Array

    def __post_init__(self) -> None:
        """Check the shapes."""
        n_feature = self.standardised.kept.size
        contract.require_shape(self.low, n_feature - 1)
        contract.require_shape(self.high, n_feature - 1)
        contract.require_shape(self.coefficients, n_feature * (n_feature + 1) // 2)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        features = self.standardised(values)
        terms = quadratic_terms(np.clip(features[:, 1:], self.low, self.high))
        expected = contract.row_products(terms, self.coefficients[:, None])[:, 0]
        return np.asarray((features[:, 0] - expected) * self.standardised.scale[0])


class Compensated(contract.Score):
    """The first feature minus its quadratic regression on the others, fitted on healthy records only.

    Proxies are limited to the range of the fit records, so that the quadratic does not extrapolate; a shift
    beyond the range remains in the score. Fit records with a standardised feature beyond ±5 are not used.

    y − Σ b_jk p_j p_k, p_0 = 1, p_j the proxies within the range of the fit records, b by least squares.

    Worden, Sohn and Farrar, J. Sound Vib. 258 (2002) 741, on novelty detection under varying conditions.
    """

    name = "compensated"
    summary = "The first feature minus its quadratic regression on the others, fitted to healthy records."
    caution = (
        "It removes only effects that the proxies explain. If few nuisances vary, the proxies explain all"
        " of them, and leaks are detected that would be missed otherwise: use records in which everything"
        " varies that varies on the machine. If a leak changes a proxy, part of its effect is also"
        " compensated. Proxies are limited to the range of the fit records, so a shift is compensated only"
        " within it."
    )
    Trained = Residual
    needs_extra = False
    direction = None

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Fit by least squares to healthy records."""
        if values.shape[1] < 2:
            raise NotStatedError("the score compensated needs a feature and at least one proxy")
        standardised = contract.standardisation(values)
        if standardised.kept[0] != 0:
            raise NotStatedError("the score compensated: its feature does not vary among healthy fit records")
        features = _near(standardised(values))
        proxies = features[:, 1:]
        coefficients = _regression(features[:, 0], quadratic_terms(proxies), self.name)
        return Residual(standardised, proxies.min(axis=0), proxies.max(axis=0), coefficients)


@dataclass(frozen=True, eq=False)
class LargestResidual(contract.Rule):
    """Largest residual of some features, in the unit of the first.

    Attributes
    ----------
    origin : float
        Score of a residual of zero.
    standardised : Standardisation
        Of the features, and of the proxies behind them.
    scale : ndarray, shape (n_of,)
        Spread of each residual of a standardised feature.
    coefficients : ndarray, shape (n_of, n_term)
    variance : ndarray, shape (n_term, n_term)
        Covariance of the coefficients over the variance of the residual.
    low, high : ndarray, shape (n_proxy,)
        Range of the standardised proxies in the fit records.
    """

    origin: float
    standardised: contract.Standardisation
    scale: Array
    coefficients: Array
    variance: Array
    low: Array
    high: Array

    def __post_init__(self) -> None:
        """Check the shapes."""
        n_of, n_proxy = self.scale.size, self.low.size
        n_term = (n_proxy + 1) * (n_proxy + 2) // 2
        contract.require_shape(self.standardised.kept, n_of + n_proxy)
        contract.require_shape(self.scale, n_of)
        contract.require_shape(self.coefficients, n_of, n_term)
        contract.require_shape(self.variance, n_term, n_term)
        contract.require_shape(self.high, n_proxy)

    @property
    def spread(self) -> Array:
        """Healthy spread of the residual of each feature, in its own unit."""
        return self.standardised.scale[: self.scale.size] * self.scale

    def spreads(self, values: Array) -> Array:
        """Residual of each feature beyond its allowance, in healthy spreads, shape (n_record, n_of)."""
        features, n_of = self.standardised(values), self.scale.size
        proxies, n_linear = features[:, n_of:], 1 + self.low.size
        left = features[:, :n_of] - contract.row_products(quadratic_terms(proxies), self.coefficients.T)
        # twice the curvature beyond the fit records bounds the terms of higher order
        beyond = quadratic_terms(proxies - np.clip(proxies, self.low, self.high))[:, n_linear:]
        allowance = 2.0 * np.abs(
            contract.row_products(np.ascontiguousarray(beyond), self.coefficients[:, n_linear:].T)
        )
        return np.asarray(np.sign(left) * np.maximum(np.abs(left) - allowance, 0.0) / self.scale)

    def widening(self, values: Array) -> Array:
        """Deviation of a prediction over that at the nearest proxies of fit records, shape (n_record,)."""
        proxies = self.standardised(values)[:, self.scale.size :]
        both = map(quadratic_terms, (proxies, np.clip(proxies, self.low, self.high)))
        here, there = (
            1.0 + np.sum(contract.row_products(each, self.variance) * each, axis=1) for each in both
        )
        return np.asarray(np.sqrt(here / there))

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        largest = self.spreads(values).max(axis=1) / self.widening(values)
        return np.asarray(self.origin + self.spread[0] * largest)


class Either(contract.Score):
    """The feature that is farthest above what the proxies explain, in the unit of the first.

    Thus each has a limit of its own, and all keep one false-alarm rate together. Proxies are extrapolated;
    beyond the fit records, residuals lose twice the part of the extrapolation that is curvature, and the
    score shrinks by as much as the prediction is less certain than at the nearest proxies of fit records.

    c + s_1 max_i (y_i − Σ b_ijk p_j p_k)/s_i √((1 + h_0)/(1 + h)), p_0 = 1, b by least squares, s_i the
    healthy spreads, h = tᵀ (TᵀT)⁻¹ t of the terms t, h_0 with the nearest proxies of the fit records; c = 0.
    Without proxies, b_i00 are the healthy medians, and c = b_100.

    Montgomery, Peck and Vining, Introduction to Linear Regression Analysis (2012), section 3.5, on h.
    """

    name = "either"
    summary = "The number that is farthest above what the conditions explain, in the unit of the first."
    Trained = LargestResidual
    least = 2  # a median and a spread
    needs_extra = False
    direction = None

    proxies: Annotated[int, Field(ge=0)] = 0
    """How many of the numbers, the last ones, are conditions that explain the others."""

    def learn(self, values: Array, is_faulty: contract.Flags) -> contract.Rule:
        """Fit by least squares to healthy records."""
        standardised = contract.standardisation(values)
        n_of = int(np.sum(standardised.kept < values.shape[1] - self.proxies))
        if standardised.kept[0] != 0:
            raise NotStatedError("the score either: its first number does not vary among healthy fit records")
        features = _near(standardised(values))
        of, proxies = features[:, :n_of], features[:, n_of:]
        terms = quadratic_terms(proxies)
        coefficients, origin = np.zeros((n_of, 1)), float(standardised.centre[0])
        if proxies.shape[1]:
            coefficients, origin = np.ascontiguousarray(_regression(of, terms, self.name).T), 0.0
        scale = contract.standardisation(of - terms @ coefficients.T).scale
        variance = np.asarray(np.linalg.pinv(terms.T @ terms), dtype=float)
        low, high = proxies.min(axis=0), proxies.max(axis=0)
        return LargestResidual(origin, standardised, scale, coefficients, variance, low, high)


def _near(features: Array) -> Array:
    """Standardised fit records that are not wild, so that single ones do not rule a fit."""
    return np.asarray(features[np.abs(features).max(axis=1) <= contract.FAR])


def _regression(features: Array, terms: Array, name: str) -> Array:
    """Coefficients of one feature, or shape (n_term, n_feature), by least squares."""
    if len(terms) < (needed := RECORDS_PER_COEFFICIENT * terms.shape[1]):
        raise NotStatedError(
            f"the score {name} has {terms.shape[1]} coefficients and needs {needed} healthy fit records that"
            f" have all features, none beyond ±{contract.FAR:g} standard deviations, not {len(terms)}",
            needed,
        )
    return np.asarray(np.linalg.lstsq(terms, features, rcond=None)[0], dtype=float)


def quadratic_terms(proxies: Array) -> Array:
    """Terms 1, p_j and p_j p_k for j ≤ k.

    Returns
    -------
    terms : ndarray, shape (n_record, (n_proxy + 1) (n_proxy + 2)/2)
    """
    columns = [np.ones(proxies.shape[0]), *proxies.T]
    return np.stack([first * second for first, second in combinations_with_replacement(columns, 2)], axis=1)
