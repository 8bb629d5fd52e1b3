"""Table 3: δ of all modes and of the sealed controls against both baselines."""

from __future__ import annotations

from dataclasses import replace

from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block
from hydrofdi.report.sections.changes import changes_block


def table3_block(study: Study) -> Block:
    """The table of all runs under the paper's name; the RMS alone, and why, where δ says nothing."""
    block = changes_block(study, "Table 3: change of the details with leakage and EBM", "table3")
    reason = study.missing_baseline or study.no_changes
    return replace(block, paragraphs=(reason, *block.paragraphs)) if reason else block
