"""The report of a judged study; delays and alarms of its control charts, and estimates against the truth."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from hydrofdi.report.detection import answer, populations, record
from hydrofdi.report.detection.record import run_length_lines
from hydrofdi.report.detection.wording import finds
from hydrofdi.report.document import (
    Block,
    Document,
    FigureKind,
    answers,
    document_of,
    doubts_blocks,
    holes_block,
    provenance_block,
    remarks_block,
)
from hydrofdi.report.runs import joined
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import STATUS
from hydrofdi.studies.detecting import (
    ERROR,
    REFERENCE_PRESSURE,
    estimated,
    judge_charts,
    judge_estimates,
    judge_study,
    winner,
)
from hydrofdi.studies.reading import uses_extra
from hydrofdi.studies.records import Detection
from hydrofdi.tables.table import Table, group_breaks

_LEAD = "Which leak is found, with which sensors and which score, at a stated rate of false alarms."


def report_study(data: ExperimentData) -> DetectionReport:
    """Judge a stored study and report on it.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    """
    report = DetectionReport(data.experiment.name, data.path, judge_study(data), data)
    if not report.has_results:
        return report
    charted = (replace(each, charts=tuple(judge_charts(data, each.records))) for each in report.detections)
    return replace(report, detections=tuple(charted))


@dataclass(frozen=True)
class DetectionReport:
    """The report of a judged study, of simulated or measured records.

    Attributes
    ----------
    detections : tuple of Detection
        One for each design of the records; the sections show the first.
    """

    name: str
    path: Path
    detections: tuple[Detection, ...]
    data: ExperimentData | None = None

    @cached_property
    def estimates(self) -> list[list[dict[str, Any]]]:
        """Estimates against the truth, for each design; empty if the truth is not known."""
        data = self.data
        return [judge_estimates(data, each.records) for each in self.detections] if data else []

    @property
    def is_complete(self) -> bool:
        """Whether no record is still to come."""
        return self.data is None or populations.n_computed_of(self.data) == self.data.n_run

    @property
    def has_results(self) -> bool:
        """Whether any record can be judged; otherwise the report says only what is missing."""
        return self.data is None or bool((self.data.columns[STATUS].astype(str) == "ok").any())

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        return "ranking"

    @property
    def _without_noise(self) -> tuple[str, ...]:
        return populations.without_noise(self.data.experiment, self.detections[0]) if self.data else ()

    def document(self) -> Document:
        """The sections of the report."""
        first, data, is_complete = self.detections[0], self.data, self.is_complete
        missing = (remarks_block(data), holes_block(data)) if data else ()
        after = (provenance_block(_with_extra(data)),) if data else ()
        if not self.has_results:
            return document_of(self.name, _LEAD, (*answers(*missing), *after))
        best = answer.answer_block(first, is_complete=is_complete, without_noise=self._without_noise)
        blocks = (
            *answers(*missing),
            *(doubts_blocks(data) if data else ()),
            *answers(best, self._training),
            populations.populations_block(first, data.experiment if data else None),
            answer.ranking_block(first),
            answer.false_alarms_block(first),
            run_lengths_block(first) if first.charts and is_complete else None,
            answer.levels_block(first),
            estimates_block(data, self.estimates[0]) if data else None,
            populations.why_block(first) if is_complete else None,
            answer.designs_block(self.detections) if is_complete else None,
            answer.remarks_block(first),
            *after,
        )
        return document_of(self.name, _LEAD, blocks)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        data = self.data
        runs = {"runs_computed": populations.n_computed_of(data), "runs_planned": data.n_run} if data else {}
        return {
            "experiment": self.name,
            "is_complete": self.is_complete,
            "perfect_sensors": list(self._without_noise),
            **runs,
            "detection": [one for each in self.detections for one in record.detection_records(each)],
            "estimates": [row for rows in self.estimates for row in rows],
            "run_lengths": record.run_length_records(self.detections),
            "studies": [record.study_record(detection) for detection in self.detections],
        }

    def wide(self) -> dict[str, list[Any]]:
        """The same: a study has no levels."""
        return self.columns()

    def columns(self) -> dict[str, list[Any]]:
        """Header → values, one line per score and tested population, and per chart, limit and population."""
        lines = [*record.detection_lines(self.detections)]
        for each in self.detections:
            lines += (record.design_record(each) | line for line in run_length_lines(each))
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
        if self.data is None or not self.is_complete or best is None or not finds(best):
            return None
        folder = shlex.quote(str(self.data.path.parent))
        command = f"hydrofdi train {folder} --best --out detector.json"
        return Block("train", "Train the winner", (f"train the winner: {command}",))

    def checks(self) -> dict[str, bool | None]:
        """Nothing: a study states no goals."""
        return {}


def _with_extra(data: ExperimentData) -> ExperimentData:
    """The same with the version of scikit-learn, where scores were made with it for this report."""
    if not uses_extra(data.experiment.detection):
        return data
    return replace(data, versions=data.versions | {"scikit-learn": version("scikit-learn")})


_CHARTS = (
    "Charts leave out the transient of the estimator and restart after each alarm. Healthy fit records, "
    "resampled whole and joined, set the limits; all results come from other records. A delay is the"
    " time from the onset of a leak to the first alarm after it; alarms before it are false ones (early)."
)


_DULL = ("unit", "kind", "not_measurable")


def run_lengths_block(detection: Detection) -> Block:
    """Delays of detection for each time between false alarms, alarms, and why a chart has none."""
    lines, confidence = [*run_length_lines(detection)], f"{100.0 * detection.rules.confidence:g} %"
    refusals = [record.chart_record(chart) | {"refused": why}
                for chart in detection.charts for why in chart.refusals]  # fmt: skip
    note = f"low, high: {confidence} interval. –: longer than the records, or no alarm in them."
    delays = [line for line in lines if "found" in line]
    alarms = [line for line in lines if "alarms" in line]
    title = "Mean time between false alarms, as measured"
    tables = (
        Table.of_records(delays, _DULL, title="Delay after the onset", key="delays"),
        Table.of_records(alarms, _DULL, title=title, key="times-between-false-alarms", notes=(note,)),
        Table.of_records(refusals, _DULL, title="Not stated"),
    )
    figures = ("delays",) if any(chart.delays for chart in detection.charts) else ()
    return Block("run-lengths", "Delay in operation", (_CHARTS,), tables, figures)


_ORDER = (
    "The truth is known only for simulated records, and no indicator sees it. Error: estimate minus truth."
)


def estimates_block(data: ExperimentData, rows: list[dict[str, Any]]) -> Block | None:
    """How far estimates are from the truth; None if nothing is estimated."""
    if not rows:
        return None
    level = f"{100.0 * data.experiment.detection.confidence:g} %"
    note = (
        f"Leakage: the flow of K_i at {REFERENCE_PRESSURE / 1e6:g} MPa. Deviations: 1σ of the errors, and as"
        f" stated (root mean square). Covered: share of the records whose stated {level} interval contains"
        f" the truth, with its {level} interval."
    )
    if data.experiment.leakage.onset != "constant":
        note += " Faults are left out: leaks set in during the record, so there is no single true value."
    if without := [name for name, _ in estimated(data) if f"{name}{ERROR}" not in data.columns]:
        note += f" Not listed because they state no deviation: {joined(without)}."
    breaks = group_breaks([(row["indicator"], row["quantity"]) for row in rows])
    title = "Estimates against the truth"
    table = Table.of_records(rows, title=title, key="estimates", notes=(note,), breaks=breaks)
    return Block("estimates", "Estimates", (_ORDER,), (table,))
