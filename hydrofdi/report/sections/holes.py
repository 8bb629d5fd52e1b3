"""What is missing, and why; and what is to be known of all rows."""

from __future__ import annotations

from collections import Counter

from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block
from hydrofdi.report.wording import counted, labels_text, mode_name
from hydrofdi.store import ExperimentData

_MOST = 20
"""Holes that are listed one by one."""


def remarks_block(data: ExperimentData) -> Block | None:
    """What is to be known of all rows: their physics is another, or they answer to another request."""
    sentences = [*data.remarks]
    if data.physics_version != PHYSICS_VERSION:
        sentences.append(
            f"Computed with version {data.physics_version} of the physics; this hydrofdi has version"
            f" {PHYSICS_VERSION}, and runs that are computed now may differ."
        )
    return Block("remarks", "Remarks", tuple(sentences)) if sentences else None


def holes_block(analysis: Analysis) -> Block | None:
    """A sentence on each run that did not end well or was not computed; None where all did."""
    holes = [row for row in analysis.table.rows if row.status != "ok"]
    if not holes:
        return None
    kinds = ", ".join(f"{count} {status}" for status, count in Counter(row.status for row in holes).items())
    sentences = [f"{len(holes)} of {counted(len(analysis.table.rows), 'run')} have no results: {kinds}."]
    for row in holes[:_MOST]:
        labels = f", {labels_text(row.labels)}" if row.labels else ""
        mode = mode_name(row.leakage_flow, row.bulk_modulus)
        sentences.append(f"{mode}{labels}: {row.status}: {row.message}")
    if len(holes) > _MOST:
        sentences.append(f"… and {len(holes) - _MOST} more; the CSV file has all of them.")
    return Block("holes", "What is missing", tuple(sentences))
