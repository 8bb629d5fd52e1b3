"""Scores that are omitted because a sensor or an optional extra is missing."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from hydrofdi.config.study.detection import DetectionConfig, ScoreConfig
from hydrofdi.records import Channel
from hydrofdi.scoring import EXTRA, has_extra
from hydrofdi.studies.made_scores import belongs
from hydrofdi.studies.records import Scored

_WITHOUT_EXTRA = ("compensated", "largest_change")
"""Kinds of scores that do not need scikit-learn."""


def within(scored: Scored, sensors: Collection[str]) -> bool:
    """Whether a score needs only these sensors; an empty collection means all sensors."""
    return not sensors or set(scored.channels) <= set(sensors)


def makeable_within(score: ScoreConfig, numbers: Sequence[Scored], kept: Sequence[Scored]) -> bool:
    """Whether a score uses no number that is omitted because of its channels."""
    kept_names = {each.name for each in kept}
    lacking = [each.name for each in numbers if each.name not in kept_names]
    return not any(belongs(number, name) for name in (*score.of, *score.by) for number in lacking)


def sensor_remark(label: str, scored: Scored, sensors: Collection[str]) -> str:
    """Message why an indicator is omitted."""
    lacking = ", ".join(Channel(name).symbol for name in scored.channels if name not in sensors)
    return f"{label} is left out: it needs {lacking}, not among detection.sensors"


def needs_extra(score: ScoreConfig) -> bool:
    """Whether a score needs scikit-learn."""
    return score.kind not in _WITHOUT_EXTRA


def asks_for_extra(detection: DetectionConfig) -> bool:
    """Whether any score of a study needs scikit-learn."""
    return detection.usual_scores or any(map(needs_extra, detection.scores.values()))


def makeable(wanted: Mapping[str, ScoreConfig]) -> tuple[dict[str, ScoreConfig], tuple[str, ...]]:
    """Scores that can be made, and a remark on those that cannot, if any."""
    lacking = [label for label, score in wanted.items() if needs_extra(score)]
    if not lacking or has_extra():
        return dict(wanted), ()
    remark = f"omitted because they need the extra ({EXTRA}): {', '.join(lacking)}"
    return {label: score for label, score in wanted.items() if label not in lacking}, (remark,)
