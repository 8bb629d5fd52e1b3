"""Changes of scores since an earlier healthy record of the same actuator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.scores.configuration import CHANGE
from hydrofdi.evaluation.populations import Kind
from hydrofdi.studies.records import Scored, StudyRecords

NONE = -1

NOTE = "minus its value in an earlier healthy record of the same actuator"


def changes_since_before(records: StudyRecords, scores: Sequence[Scored]) -> Iterator[Scored]:
    """Change of each score since the earlier record of the same group.

    This removes constants of an actuator, such as the null leakage of its valve or the bias of a sensor.
    There are no changes if there are no earlier records; they are NaN for records of a group without one.

    Parameters
    ----------
    records : StudyRecords
        Records with groups: one group per actuator.
    scores : sequence of Scored
    """
    before = _before(records)
    if before is None:
        return
    for scored in scores:
        earlier = np.where(before == NONE, np.nan, scored.values[before])
        yield replace(
            scored,
            name=f"{scored.name}{CHANGE}",
            values=scored.values - earlier,
            long_name=f"change of: {scored.long_name}",
            note="; ".join(filter(None, (scored.note, NOTE))),
        )


def _before(records: StudyRecords) -> NDArray[np.intp] | None:
    """Row of the earlier record of each record, or ``NONE``; None if there are no earlier records."""
    populations = [each for each in records.populations if each.kind is Kind.BEFORE]
    if records.groups is None or not populations:
        return None
    rows = np.concatenate([records.rows(each) for each in populations]).tolist()
    row_of_group = {records.groups[row]: row for row in rows}
    return np.array([row_of_group.get(group, NONE) for group in records.groups], dtype=np.intp)
