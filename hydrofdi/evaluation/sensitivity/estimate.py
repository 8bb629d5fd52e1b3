"""An estimate with its interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True)
class Estimate:
    """An estimate with its two-sided interval.

    Attributes
    ----------
    value, low, high, confidence : float
    n_record : int
        Number of records used.
    """

    value: float
    low: float
    high: float
    confidence: float
    n_record: int

    @classmethod
    def of(cls, value: float, draws: Array, confidence: float, n_record: int) -> Estimate:
        """Estimate with the central interval of bootstrap draws, shape (n_draw,)."""
        low, high = np.quantile(draws, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
        return cls(float(value), float(low), float(high), confidence, n_record)
