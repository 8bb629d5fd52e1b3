"""The scores of several numbers that are made where nobody chose any."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrofdi.evaluation.populations import Kind
from hydrofdi.studies.learning import LARGEST_CHANGE, Made
from hydrofdi.studies.records import Scored, StudyRecords

LEAST_SHARE = 0.99
"""Share of the healthy fit records in which a number has to be measured to be used."""

_SYMBOLS = {
    "chamber_1_pressure": "P1", "chamber_2_pressure": "P2", "supply_pressure": "Ps", "return_pressure": "Pr",
    "piston_position": "x", "piston_velocity": "v", "spool_position": "xv", "input_voltage": "u",
}  # fmt: skip


def usual_scores(records: StudyRecords, scores: Sequence[Scored]) -> dict[str, Made]:
    """For every set of sensors that some indicator needs: one score of all numbers that these sensors give.

    ``mahalanobis`` from healthy fit records, and ``lda`` where there are faulty ones as well. Numbers
    that more than a hundredth of the healthy fit records lack are left out. Beside them the rule of the
    paper, the largest fall of d1 … d5.

    Parameters
    ----------
    records : StudyRecords
    scores : sequence of Scored
    """
    kinds = ["mahalanobis", *(["lda"] if records.chosen(Kind.FAULT, is_fit=True) else [])]
    healthy = [records.rows(each) for each in records.chosen(Kind.HEALTHY, is_fit=True)]
    rows = np.concatenate(healthy) if healthy else np.empty(0, dtype=np.intp)
    usable = [
        each
        for each in scores
        if each.channels and rows.size and np.isfinite(each.values[rows]).mean() >= LEAST_SHARE
    ]
    made: dict[str, Made] = {}
    for sensors in dict.fromkeys(each.channels for each in usable):
        names = tuple(each.name for each in usable if set(each.channels) <= set(sensors))
        if len(names) > 1:
            title = " ".join(_SYMBOLS.get(channel, channel) for channel in sensors)
            made |= {f"{kind}({title})": Made(kind, names) for kind in kinds}
    details = tuple(each.name for each in scores if each.name in {f"dwt.d{level}" for level in range(1, 6)})
    return made | ({"largest_change(d1 … d5)": Made(LARGEST_CHANGE, details)} if len(details) == 5 else {})
