"""Table 3: δ of all modes and of the sealed controls against both baselines."""

from __future__ import annotations

from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block
from hydrofdi.report.sections.changes import changes_block


def table3_block(study: Study) -> Block:
    """The table of all runs under the paper's name; the RMS alone where no run is healthy."""
    return changes_block(study, "Table 3: change of the details with leakage and EBM", "table3")
