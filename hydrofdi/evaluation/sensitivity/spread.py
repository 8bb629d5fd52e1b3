"""Spread of a score from a single nuisance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.sensitivity.estimate import Estimate
from hydrofdi.evaluation.sensitivity.quantiles import INNER, quantiles_and_draws


def relative_spread(
    alone: ArrayLike, together: ArrayLike, *, confidence: float = 0.95, seed: int = 0
) -> Estimate:
    """Inner 90 % range of a score with one nuisance, relative to the range with all nuisances.

    Parameters
    ----------
    alone, together : array_like, shape (n_record,)
        Scores of healthy records in which one nuisance varies, or all vary; NaN if a record has no score.
    confidence : float
    seed : int
        Seed of the draws for the interval.

    Raises
    ------
    NotStatedError
        Fewer than 49 records of one kind have a score, or nine in ten scores with all nuisances are equal.
    """
    draw = np.random.default_rng(seed)
    scores = np.asarray(alone, dtype=float)
    one, one_drawn = quantiles_and_draws(scores, INNER, draw)
    every, every_drawn = quantiles_and_draws(np.asarray(together, dtype=float), INNER, draw)
    width, widths = float(np.ptp(every)), np.ptp(every_drawn, axis=1)
    if not widths.all() or not width:
        raise NotStatedError("the score is the same in nine healthy records of ten: it has no spread")
    n_record = int(np.isfinite(scores).sum())
    return Estimate.of(np.ptp(one) / width, np.ptp(one_drawn, axis=1) / widths, confidence, n_record)
