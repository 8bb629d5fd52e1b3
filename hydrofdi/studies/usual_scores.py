"""Default combined scores."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.config.study.detection import ScoreConfig
from hydrofdi.evaluation.populations import Kind
from hydrofdi.records import Channel
from hydrofdi.studies.records import Scored, StudyRecords

_DETAILS = tuple(f"dwt.d{level}" for level in range(1, 6))


def usual_scores(
    records: StudyRecords, scores: Sequence[Scored], *, tested_teach: bool = False
) -> dict[str, ScoreConfig]:
    """Default scores: for every set of sensors, a score of all numbers that these sensors give.

    ``mahalanobis`` from healthy fit records, and ``lda`` if there are faulty fit records; in addition the
    rule of the paper, the largest fall of d1 … d5.

    Parameters
    ----------
    records : StudyRecords
    scores : sequence of Scored
    tested_teach : bool
        Whether faulty test records may be used for training, as in `made_scores`.
    """
    teachers = records.chosen(Kind.FAULT, is_fit=True)
    if tested_teach:
        teachers += records.chosen(Kind.FAULT, is_fit=False)
    kinds = ["mahalanobis", *(["lda"] if teachers else [])]
    made: dict[str, ScoreConfig] = {}
    for sensors in dict.fromkeys(each.channels for each in scores if each.channels):
        names = [each.name for each in scores if each.channels and set(each.channels) <= set(sensors)]
        if len(names) > 1:
            title = " ".join(Channel(channel).symbol for channel in sensors)
            made |= {
                f"{kind}({title})": ScoreConfig.model_validate({"kind": kind, "of": names}) for kind in kinds
            }
    details = [each.name for each in scores if each.name in _DETAILS]
    if len(details) == len(_DETAILS):
        made["largest_change(d1 … d5)"] = ScoreConfig(kind="largest_change", of=details)
    return made
