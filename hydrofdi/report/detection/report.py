"""The report of a judged study; delays and alarms of its control charts, and estimates against the truth."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any

from hydrofdi.report.detection import record, sections
from hydrofdi.report.document import Block, ComposedReport, FigureKind
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import MISSING, STATUS
from hydrofdi.studies.detecting import judge_charts, judge_estimates, judge_study, winner
from hydrofdi.studies.reading import uses_extra
from hydrofdi.studies.records import Detection


def report_study(data: ExperimentData) -> DetectionReport:
    """Judge a stored study and report on it.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    """
    if uses_extra(data.experiment.detection):
        data = replace(data, versions=data.versions | {"scikit-learn": version("scikit-learn")})
    report = DetectionReport(judge_study(data), data)
    if not report.has_results:
        return report
    charted = (replace(each, charts=tuple(judge_charts(data, each.records))) for each in report.detections)
    return replace(report, detections=tuple(charted))


@dataclass(frozen=True)
class DetectionReport(ComposedReport):
    """The report of a judged study, of simulated or measured records.

    Attributes
    ----------
    detections : tuple of Detection
        One for each design of the records; the sections show the first.
    """

    detections: tuple[Detection, ...]
    data: ExperimentData | None = None

    lead = "Which leak is found, with which sensors and which score, at a stated rate of false alarms."

    @cached_property
    def estimates(self) -> list[list[dict[str, Any]]]:
        """Estimates against the truth, for each design; empty if the truth is not known."""
        data = self.data
        return [judge_estimates(data, each.records) for each in self.detections] if data else []

    @property
    def _n_computed(self) -> int:
        return int((self.data.columns[STATUS].astype(str) != MISSING).sum()) if self.data else 0

    @property
    def is_complete(self) -> bool:
        """Whether no record is still to come."""
        return self.data is None or self._n_computed == self.data.n_run

    def blocks(self) -> Iterator[Block | None]:
        """Its own sections."""
        first, data, is_complete = self.detections[0], self.data, self.is_complete
        yield sections.answer_block(first, data.experiment if data else None, is_complete=is_complete)
        yield self._training
        yield sections.populations_block(first, data.experiment if data else None)
        yield sections.ranking_block(first)
        yield sections.false_alarms_block(first)
        yield sections.run_lengths_block(first) if first.charts and is_complete else None
        yield sections.levels_block(first)
        yield sections.estimates_block(data, self.estimates[0]) if data else None
        yield sections.why_block(first) if is_complete else None
        yield sections.designs_block(self.detections) if is_complete else None
        yield sections.remarks_block(first)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        data = self.data
        runs = {"runs_computed": self._n_computed, "runs_planned": data.n_run} if data else {}
        return {
            "experiment": self.name,
            "is_complete": self.is_complete,
            **runs,
            "detection": [one for each in self.detections for one in record.detection_records(each)],
            "estimates": [row for rows in self.estimates for row in rows],
            "run_lengths": record.run_length_records(self.detections),
            "studies": [record.study_record(detection) for detection in self.detections],
        }

    def columns(self) -> dict[str, list[Any]]:
        """Header → values, one line per score and tested population, and per chart, limit and population."""
        lines = [*record.detection_lines(self.detections)]
        for each in self.detections:
            lines += (record.design_record(each) | line for line in record.run_length_lines(each))
        headers = dict.fromkeys(header for line in lines for header in line)
        return {header: [line.get(header) for line in lines] for header in headers}

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure; none without results."""
        if not self.has_results:
            return {}
        from hydrofdi.report.figures.detection import detection_figures

        return detection_figures(self.detections[0])

    @property
    def _training(self) -> Block | None:
        """The command that trains the winner, if it finds anything."""
        best = winner(self.detections[0])
        if self.data is None or not self.is_complete or best is None or not best.finds:
            return None
        folder = shlex.quote(str(self.data.path.parent))
        command = f"hydrofdi train {folder} --best --out detector.json"
        return Block("train", "Train the winner", (f"train the winner: {command}",), is_answer=True)
