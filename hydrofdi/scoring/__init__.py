"""Scores: one number for each record from several that were measured of it. The larger, the more suspicious.

A score learns from fit records: healthy ones, and faulty ones where it needs them. It knows numbers and these
labels, and nothing of the plant or of how severe a fault is.
"""

from hydrofdi.scoring.contract import Fitted, Score
from hydrofdi.scoring.cross_fitting import cross_fitted_scores
from hydrofdi.scoring.extra import EXTRA, has_extra
from hydrofdi.scoring.registry import make_score, score_kind, score_names

__all__ = [
    "EXTRA",
    "Fitted",
    "Score",
    "cross_fitted_scores",
    "has_extra",
    "make_score",
    "score_kind",
    "score_names",
]
