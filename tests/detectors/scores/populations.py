"""Records with known truth: features that a few nuisances move, and a fault."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Population:
    """Features that four uniform nuisances move along curves; a fault moves them along a line of its own."""

    n_feature: int = 6
    noise: float = 0.1
    seed: int = 0
    draw: np.random.Generator = field(init=False)

    def __post_init__(self):
        self.draw = np.random.default_rng(self.seed)
        self.slopes = self.draw.normal(size=(4, self.n_feature))
        self.curves = 0.3 * self.draw.normal(size=(4, self.n_feature))
        self.fault = self.draw.normal(size=self.n_feature)

    def records(self, n_record, severity=0.0):
        nuisance = self.draw.uniform(-1.0, 1.0, (n_record, 4))
        spread = self.noise * self.draw.normal(size=(n_record, self.n_feature))
        return nuisance @ self.slopes + nuisance**2 @ self.curves + severity * self.fault + spread

    def labelled(self, n_healthy, n_faulty, severity):
        values = np.vstack([self.records(n_healthy), self.records(n_faulty, severity)])
        return values, np.arange(n_healthy + n_faulty) >= n_healthy


def gaussians(draw, n_each, covariance, distance):
    """Healthy and faulty records of one covariance, their means apart by `distance`; and the labels."""
    values = draw.multivariate_normal(np.zeros(len(distance)), covariance, size=2 * n_each)
    is_faulty = np.arange(2 * n_each) >= n_each
    return values + np.outer(is_faulty, distance), is_faulty
