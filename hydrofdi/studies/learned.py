"""Scores of a study that need the extra to learn with."""

from __future__ import annotations

from collections.abc import Mapping

from hydrofdi.config.study.detection import DetectionConfig, ScoreConfig
from hydrofdi.scoring import EXTRA, has_extra

_WITHOUT_EXTRA = ("compensated", "largest_change")
"""Kinds of scores that are made without scikit-learn."""


def needs_extra(score: ScoreConfig) -> bool:
    """Whether a score is made with scikit-learn."""
    return score.kind not in _WITHOUT_EXTRA


def asks_for_extra(detection: DetectionConfig) -> bool:
    """Whether any score that a study asks for is made with scikit-learn."""
    return detection.usual_scores or any(map(needs_extra, detection.scores.values()))


def makeable(wanted: Mapping[str, ScoreConfig]) -> tuple[dict[str, ScoreConfig], tuple[str, ...]]:
    """The scores that can be made here, and a sentence on those that cannot, where there are any."""
    lacking = [label for label, score in wanted.items() if needs_extra(score)]
    if not lacking or has_extra():
        return dict(wanted), ()
    remark = f"left out, for they need the extra ({EXTRA}): {', '.join(lacking)}"
    return {label: score for label, score in wanted.items() if label not in lacking}, (remark,)
