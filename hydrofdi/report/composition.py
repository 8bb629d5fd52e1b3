"""The sections of the report of any experiment, and the forms in which it comes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

from hydrofdi.report import changes
from hydrofdi.report.data import ReportData
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.plane import matrix_block
from hydrofdi.report.provenance import machine_block, provenance_block
from hydrofdi.report.record import general_record, tidy_columns, wide_columns
from hydrofdi.report.responses import responses_block, responses_record
from hydrofdi.report.table import Block, Document, FigureKind
from hydrofdi.report.views import View, asked_views
from hydrofdi.store.experiment_data import ExperimentData


@dataclass(frozen=True)
class Report(ReportData):
    """The report of an experiment, in parts that forms are made from; a paper's study adds its own."""

    lead: ClassVar[str] = "Indicators of the runs, and how they change over the varied parameters."

    @cached_property
    def views(self) -> tuple[View, ...]:
        """Sections, and data for JSON, of what the experiment asks for beyond indicators."""
        wanted = self.has_details and self.has_results
        return tuple(asked_views(self.table)) if wanted else ()

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        return "sensitivity" if self.plane else "responses"

    def document(self) -> Document:
        """The sections of the report; of an experiment without results what is missing, and the remedy."""
        data = self.data
        if self.has_results:
            return document_of(self.name, self.lead, self.blocks(), data)
        blocks = (
            changes.remarks_block(data),
            changes.holes_block(data),
            *answers(changes.varied_block(self)),
        )
        return document_of(self.name, self.lead, (*blocks, provenance_block(data)))

    def blocks(self) -> Iterable[Block | None]:
        """The sections where runs have results."""
        title = "Change of the details over the varied parameters"
        own = (changes.changes_block(self, title, "changes"),) if self.has_details else ()
        return (
            changes.remarks_block(self.data),
            changes.varied_block(self),
            changes.holes_block(self.data),
            *changes.doubts_blocks(self.data),
            matrix_block(self.plane) if self.plane else None,
            *(block for block, _ in self.views),
            responses_block(self.responses),
            *(own if self.responses.axes else answers(*own)),
            indicators_block(self.indicators),
            changes.summary_block(self),
            provenance_block(self.data),
        )

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        record = general_record(self) | responses_record(self.responses)
        return record | {key: value for _, data in self.views for key, value in data.items()}

    def columns(self) -> dict[str, list[Any]]:
        """Header → values, one per run and level."""
        return tidy_columns(self)

    def wide(self) -> dict[str, list[Any]]:
        """Header → values, one per run."""
        return wide_columns(self)

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure; none if no run has results."""
        from hydrofdi.report.figures import general_figures

        return general_figures(self) if self.has_results else {}

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
