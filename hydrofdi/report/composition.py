"""What a report says of any experiment, computed once; its sections, and the forms in which it comes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from hydrofdi.config.experiment import DWT
from hydrofdi.report import changes
from hydrofdi.report.indicators import MeasuredIndicator, indicators_block, measured_indicators
from hydrofdi.report.plane import Plane, matrix_block, plane_of
from hydrofdi.report.provenance import machine_block, provenance_block
from hydrofdi.report.record import general_record, tidy_columns, wide_columns
from hydrofdi.report.responses import ResponseStudy, responses_block, responses_record, study_responses
from hydrofdi.report.runs import RunTable, run_table
from hydrofdi.report.table import Block, Document, FigureKind
from hydrofdi.report.views import View, asked_views
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names


@dataclass(frozen=True)
class Report:
    """The report of an experiment, in parts that forms are made from; a paper's study adds its own."""

    data: ExperimentData
    lead: ClassVar[str] = "Indicators of the runs, and how they change over the varied parameters."

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        return self.data.experiment.name

    @property
    def path(self) -> Path:
        """The experiment file."""
        return self.data.path

    @cached_property
    def table(self) -> RunTable:
        """Its runs."""
        return run_table(self.data)

    @cached_property
    def indicators(self) -> tuple[MeasuredIndicator, ...]:
        """Indicators beside the details of P_1, if the experiment measures any."""
        return measured_indicators(self.data)

    @cached_property
    def responses(self) -> ResponseStudy:
        """What each feature does over each parameter that varies."""
        return study_responses(self.data, self.indicators)

    @cached_property
    def plane(self) -> Plane | None:
        """The runs over the two parameters that matter most, if they are a grid of them."""
        return plane_of(self)

    @property
    def has_details(self) -> bool:
        """Whether the experiment measures the wavelet details as configured."""
        return DWT in self.data.experiment.indicators

    @property
    def has_results(self) -> bool:
        """Whether any run has results."""
        return bool(self.table.is_ok.any())

    @property
    def has_baseline(self) -> bool:
        """Whether there is a healthy run that the others are compared with."""
        return bool((self.data.fixed_baseline != names.NO_BASELINE).any())

    @cached_property
    def baselines(self) -> tuple[str, ...]:
        """``fixed`` and ``matched``, without a baseline for which δ is zero or the same as for the other."""
        own, fixed, matched = np.arange(self.data.n_run), self.data.fixed_baseline, self.data.matched_baseline
        tells = {
            "fixed": (fixed != own) & (fixed != names.NO_BASELINE),
            "matched": (matched != own) & (matched != fixed),
        }
        return tuple(name for name, is_other in tells.items() if is_other.any())

    @property
    def no_changes(self) -> str:
        """Why there is no δ, or why it would be zero for every run; empty if there is δ."""
        if not self.has_baseline:
            alone = "it is a single run; 'hydrofdi sweep' adds the healthy ones"
            reason = alone if self.data.n_run == 1 else "the baseline itself leaks"
            return f"There is no healthy run to compare with ({reason}): δ is not known."
        if self.baselines:
            return ""
        return (
            "Each run is its own healthy baseline, because no run leaks and the baseline sets none of the"
            " varied parameters: δ is zero by construction. To see δ, set a varied parameter in the baseline."
        )

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
            *(block for block, _ in self.views),
            responses_block(self.responses),
            *(own if self.responses.axes else answers(*own)),
            indicators_block(self.indicators),
            matrix_block(self.plane) if self.plane else None,
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
