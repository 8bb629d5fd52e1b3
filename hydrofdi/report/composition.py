"""Which sections make up a report, and in which forms it comes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.changes import (
    MOST_DRAWN,
    changes_block,
    doubts_block,
    holes_block,
    remarks_block,
    summary_block,
    varied_block,
)
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.provenance import machine_block, provenance_block
from hydrofdi.report.record import general_record, tidy_columns
from hydrofdi.report.responses import responses_block, responses_record
from hydrofdi.report.table import Block, Document

if TYPE_CHECKING:
    from hydrofdi.report.table import FigureKind
    from hydrofdi.store.experiment_data import ExperimentData

FEW_AXES = 4
"""Most varied parameters for which the figure of the responses is the default."""

_LEAD = "Change δ of the RMS of the wavelet details of the chamber-1 pressure over the varied parameters."

_LEAD_WITHOUT_DETAILS = "Indicators of the runs of the experiment."


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
        is_many = len(self.analysis.table) > MOST_DRAWN
        is_clear = n_axis <= FEW_AXES or is_many or not self.analysis.baselines
        return "responses" if n_axis and is_clear else "sensitivity"

    @property
    def lead(self) -> str:
        """What the report is about."""
        return _LEAD if self.analysis.has_details else _LEAD_WITHOUT_DETAILS

    def document(self) -> Document:
        """The sections of the report; of an experiment without results what is missing, and the remedy."""
        analysis, data = self.analysis, self.analysis.data
        if analysis.has_results:
            return document_of(self.name, self.lead, self.blocks(), data)
        missing = answers(holes_block(analysis), varied_block(analysis))
        return document_of(self.name, self.lead, (remarks_block(data), *missing, provenance_block(data)))

    def blocks(self) -> Iterable[Block | None]:
        """The sections where runs have results."""
        analysis = self.analysis
        title = "Change of the details over the varied parameters"
        changes = (changes_block(analysis, title, "changes"),) if analysis.has_details else ()
        return (
            remarks_block(analysis.data),
            varied_block(analysis),
            *answers(holes_block(analysis), doubts_block(analysis)),
            *(block for block, _ in self.views),
            responses_block(analysis.responses),
            *(changes if analysis.responses.axes else answers(*changes)),
            indicators_block(analysis.indicators, analysis.table),
            summary_block(analysis),
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
        """Sentence on each check that the experiment file asks for → whether it holds; None: not decided."""
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
