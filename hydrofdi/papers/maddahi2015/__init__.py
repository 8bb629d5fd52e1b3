"""The study of Maddahi et al., CDSR 2015, paper 181: leakage over the effective bulk modulus (EBM)."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.composition import View


def asked_views(analysis: Analysis) -> Iterator[View]:
    """Sections and data of the varied external leakage, and of replicates."""
    if not (analysis.has_details and analysis.has_results):
        return
    if analysis.table.varies_external:
        from hydrofdi.papers.maddahi2015.external import external_views

        yield from external_views(analysis.table)
    if analysis.data.has_replicates:
        from hydrofdi.papers.maddahi2015.replicates import replicates_views

        yield from replicates_views(analysis.table, analysis.data)
