"""Histories of a seal that wears by a known law, with the spread of a machine from day to day."""

from dataclasses import dataclass

import numpy as np

LAWS = {
    "linear": lambda share: share,
    "accelerating, s^2.5": lambda share: share**2.5,
    "accelerating, exp 3s": lambda share: np.expm1(3.0 * share) / np.expm1(3.0),
    "sudden": lambda share: np.where(share > 0.0, 1.0, 0.0),
}
"""Growth over the share of the time from the onset to the end; both that accelerate are none of the model."""

NOISES = {
    "independent": (0.0, 0.0, None),
    "AR(1) 0.5": (0.5, 0.0, None),
    "AR(1) 0.8 and 30 % white": (0.8, 0.3, None),
    "AR(1) 0.95": (0.95, 0.0, None),
    "AR(1) 0.5, Student's t with 4": (0.5, 0.0, 4),
    "AR(1) 0.8, Student's t with 4": (0.8, 0.0, 4),
}
"""Name → correlation from day to day, share of white noise, degrees of freedom of the innovations."""


def spread(random, n_day, correlation, white, freedom=None):
    """Spread from day to day with standard deviation 1."""
    innovations = random.standard_normal(n_day)
    if freedom is not None:
        innovations = random.standard_t(freedom, n_day) / np.sqrt(freedom / (freedom - 2.0))
    found = np.empty(n_day)
    found[0] = innovations[0]
    for day in range(1, n_day):
        found[day] = correlation * found[day - 1] + np.sqrt(1.0 - correlation**2) * innovations[day]
    return np.sqrt(1.0 - white) * found + np.sqrt(white) * random.standard_normal(n_day)


@dataclass(frozen=True)
class Worn:
    """Scores of days, and the truth: the onset [days], a limit, and when the level reaches it [days]."""

    scores: np.ndarray
    onset: float
    limit: float
    reached: float


def worn(seed, n_day, law, noise):
    """A history whose level grows by 6 to 15 deviations, from an onset in its middle three fifths on.

    The limit is reached in the last third of the growth or after the end, also beyond the horizon; after a
    sudden change at its onset, or never.
    """
    random = np.random.default_rng(seed)
    end, onset, growth = n_day - 1.0, random.uniform(0.2, 0.8) * n_day, random.uniform(6.0, 15.0)
    days, grown = np.arange(n_day, dtype=float), LAWS[law]

    def level(day):
        return growth * grown(np.maximum(np.asarray(day) - onset, 0.0) / (end - onset))

    if law == "sudden":
        limit = growth * random.choice([0.5, 1.5])
        reached = onset if limit < growth else np.inf
    else:
        at = random.uniform(end - 0.3 * (end - onset), end + 1.2 * (end - onset))
        limit, reached = float(level(at)), at if at <= 2.0 * end else np.inf
    return Worn(level(days) + spread(random, n_day, *NOISES[noise]), onset, limit, reached)
