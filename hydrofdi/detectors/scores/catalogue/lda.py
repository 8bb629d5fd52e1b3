"""Linear discriminant analysis of healthy and faulty records."""

from hydrofdi.detectors.scores.contract import FROM_BOTH, Flags, Rule, Score
from hydrofdi.detectors.scores.features import LinearRule, scikit_learn, standardisation
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import Section


class Lda(Score[Section]):
    """Linear discriminant with Ledoit-Wolf shrinkage of the covariance; both classes have equal weight."""

    name = "lda"
    summary = "Linear discriminant of healthy and faulty records, with a shrunk covariance."
    source = "Fisher, Annals of Eugenics 7 (1936) 179; Ledoit and Wolf, J. Multivar. Anal. 88 (2004) 365"
    equation = "wᵀ (z − (m₀ + m₁)/2), w = C⁻¹ (m₁ − m₀), C the mean of the shrunk covariances of both kinds"
    caution = FROM_BOTH
    needs_faulty = True
    Trained = LinearRule

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Fit means and covariances of both classes."""
        standardised = standardisation(values)
        with scikit_learn(self.name):
            from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

            model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto", priors=[0.5, 0.5])
            model.fit(standardised.held(values), is_faulty)
        return LinearRule(standardised, model.coef_[0], float(model.intercept_[0]))
