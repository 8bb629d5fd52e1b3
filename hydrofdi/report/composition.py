"""Which sections make up a report, and in which forms it comes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from hydrofdi.report import changes
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.provenance import machine_block, provenance_block
from hydrofdi.report.record import general_record, tidy_columns
from hydrofdi.report.responses import responses_block, responses_record
from hydrofdi.report.table import Block, Document, FigureKind
from hydrofdi.store.experiment_data import ExperimentData

FEW_AXES = 4
"""Most varied parameters for which the figure of the responses is the default."""


View = tuple[Block, dict[str, Any]]


@dataclass(frozen=True)
class Report:
    """The report of an experiment, in parts that forms are made from; a paper's study adds its own.

    Attributes
    ----------
    analysis : Analysis
    views : tuple of View
        Sections, and data for JSON, of what the experiment asks for beyond indicators.
    """

    analysis: Analysis
    views: tuple[View, ...] = ()
    lead: ClassVar[str] = "Indicators of the runs, and how they change over the varied parameters."

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        return self.analysis.data.experiment.name

    @property
    def path(self) -> Path:
        """The experiment file."""
        return self.analysis.data.path

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        n_axis = sum(bool(each.responses) for each in self.analysis.responses.axes)
        is_many = len(self.analysis.table) > changes.MOST_DRAWN
        is_clear = n_axis <= FEW_AXES or is_many or not self.analysis.baselines
        return "responses" if n_axis and is_clear else "sensitivity"

    def document(self) -> Document:
        """The sections of the report; of an experiment without results what is missing, and the remedy."""
        analysis, data = self.analysis, self.analysis.data
        if analysis.has_results:
            return document_of(self.name, self.lead, self.blocks(), data)
        blocks = (
            changes.remarks_block(data),
            changes.holes_block(data),
            *answers(changes.varied_block(analysis)),
        )
        return document_of(self.name, self.lead, (*blocks, provenance_block(data)))

    def blocks(self) -> Iterable[Block | None]:
        """The sections where runs have results."""
        analysis = self.analysis
        title = "Change of the details over the varied parameters"
        own = (changes.changes_block(analysis, title, "changes"),) if analysis.has_details else ()
        return (
            changes.remarks_block(analysis.data),
            changes.varied_block(analysis),
            changes.holes_block(analysis.data),
            *changes.doubts_blocks(analysis.data),
            *(block for block, _ in self.views),
            responses_block(analysis.responses),
            *(own if analysis.responses.axes else answers(*own)),
            indicators_block(analysis.indicators, analysis.table),
            changes.summary_block(analysis),
            provenance_block(analysis.data),
        )

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        record = general_record(self.analysis) | responses_record(self.analysis.responses)
        return record | {key: value for _, data in self.views for key, value in data.items()}

    def columns(self) -> dict[str, list[Any]]:
        """Header → values, one per run and level."""
        return tidy_columns(self.analysis)

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure; none if no run has results."""
        from hydrofdi.report.figures import general_figures

        return general_figures(self.analysis) if self.analysis.has_results else {}

    def checks(self) -> dict[str, bool | None]:
        """Nothing: only a paper's study has claims."""
        return {}


def answers(*blocks: Block | None) -> tuple[Block | None, ...]:
    """What a terminal shows, and shows last."""
    return tuple(block and replace(block, is_answer=True) for block in blocks)


def document_of(
    title: str, lead: str, blocks: Iterable[Block | None], data: ExperimentData | None = None
) -> Document:
    """A report of the sections that there are; it begins with the machine of the data."""
    machine = (machine_block(data),) if data else ()
    return Document(title, (lead,), (*machine, *(block for block in blocks if block is not None)))
