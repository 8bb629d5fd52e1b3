"""The default scores of several numbers."""

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
    """For every set of sensors that some indicator needs: one score of all numbers that these sensors give.

    ``mahalanobis`` from healthy fit records, and ``lda`` where there are faulty ones as well. Beside them the
    rule of the paper, the largest fall of d1 … d5.

    Parameters
    ----------
    records : StudyRecords
    scores : sequence of Scored
    tested_teach : bool
        Whether faulty records that are tested may teach, as in `made_scores`.
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
