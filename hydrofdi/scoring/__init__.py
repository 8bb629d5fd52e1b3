"""Scores: one number per record, computed from several features; larger is more suspicious.

A score is trained on fit records: healthy ones, and faulty ones if it needs them. It uses only features and
these labels, not the plant or the severity of a fault.
"""

from hydrofdi.scoring.contract import Fitted, Score
from hydrofdi.scoring.cross_fitting import cross_fitted_scores
from hydrofdi.scoring.features import EXTRA, has_extra
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
