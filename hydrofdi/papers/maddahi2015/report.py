"""The report of the paper's study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hydrofdi.papers.maddahi2015.composition import compose_study
from hydrofdi.papers.maddahi2015.records.study import study_record
from hydrofdi.papers.maddahi2015.study import Study, study_experiment
from hydrofdi.report.composition import Report
from hydrofdi.report.document import Document
from hydrofdi.store import ExperimentData

if TYPE_CHECKING:
    from hydrofdi.report.contract import FigureKind


@dataclass(frozen=True)
class StudyReport(Report):
    """The general report with the paper's tables, claims, controls and figures."""

    analysis: Study

    @classmethod
    def of(cls, data: ExperimentData) -> StudyReport:
        """The report of an experiment."""
        return cls(study_experiment(data))

    @property
    def usual_figure(self) -> str:
        """The scenarios where the experiment has any, else δ."""
        return "sensitivity" if self.analysis.scenarios is None else "scenarios"

    def document(self) -> Document:
        """The sections of the report."""
        return compose_study(self.analysis)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return study_record(self.analysis)

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        from hydrofdi.papers.maddahi2015.figures import study_figures

        own = study_figures(self.analysis) if self.analysis.has_results else {}
        return {**super().figures(), **own}

    def checks(self) -> dict[str, bool | None]:
        """The claims that the experiment file lists, and whether they hold."""
        word = {True: "holds", False: "does not hold", None: "is not decided"}
        return {
            f"{result.claim.id} {word[result.reproduced]}: {result.claim.sentence}"
            f" (margin {result.margin:.2f} points)": result.reproduced
            for result in self.analysis.guarded
        }
