"""What an experiment asks for of the wavelet details: external leakage, and healthy replicates."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.papers.maddahi2015.external import (
    external_block,
    external_record,
    external_rows_table,
    study_external,
)
from hydrofdi.papers.maddahi2015.replicates import replicates_block, replicates_record, study_replicates
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.composition import View
from hydrofdi.report.document import Block


def asked_views(analysis: Analysis, levels: Sequence[int] | None = None) -> tuple[View, ...]:
    """Sections and data of the varied external leakage, and of replicates at some levels or at all."""
    table = analysis.table
    views: list[View] = []
    if not (analysis.has_details and analysis.has_results):
        return ()
    if (external := study_external(table)) is not None:
        views.append((external_block(table, external), external_record(external)))
        views.append(
            (Block("external-rows", "Runs by external leakage", (), (external_rows_table(external),)), {})
        )
    if (replicates := study_replicates(table, analysis.data)) is not None:
        block = replicates_block(table, analysis.data, replicates, levels)
        views.append((block, {"replicates": replicates_record(replicates)}))
    return tuple(views)
