"""What an experiment asks for of the wavelet details: external leakage, and healthy replicates."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.papers.maddahi2015.external import external_views
from hydrofdi.papers.maddahi2015.replicates import replicates_view, study_replicates
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.composition import View


def asked_views(analysis: Analysis, levels: Sequence[int] | None = None) -> tuple[View, ...]:
    """Sections and data of the varied external leakage, and of replicates at some levels or at all."""
    table, data = analysis.table, analysis.data
    if not (analysis.has_details and analysis.has_results):
        return ()
    external = external_views(table) if table.varies_external else ()
    replicates = study_replicates(table, data) if data.has_replicates else None
    return (*external, *([replicates_view(table, data, replicates, levels)] if replicates else []))
