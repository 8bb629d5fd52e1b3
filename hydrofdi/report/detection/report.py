"""The report of a judged study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydrofdi.report.composition import answers, document_of
from hydrofdi.report.detection.answer import answer_block
from hydrofdi.report.detection.caveats import caveats_block
from hydrofdi.report.detection.columns import detection_lines
from hydrofdi.report.detection.designs import design_records, designs_block
from hydrofdi.report.detection.false_alarms import false_alarms_block
from hydrofdi.report.detection.levels import levels_block
from hydrofdi.report.detection.populations import populations_block
from hydrofdi.report.detection.progress import Progress
from hydrofdi.report.detection.ranking import ranking_block
from hydrofdi.report.detection.record import detection_records, study_record
from hydrofdi.report.detection.sensors import Sensor, perfect_sensors, perfect_sentence
from hydrofdi.report.detection.varied import Varied
from hydrofdi.report.detection.why import why_block
from hydrofdi.report.document import Block, Document
from hydrofdi.report.estimates.block import estimate_records, estimates_block
from hydrofdi.report.run_lengths.block import run_lengths_block
from hydrofdi.report.run_lengths.record import run_length_lines, run_length_records
from hydrofdi.studies.estimates.judging import Estimates
from hydrofdi.studies.judgement import Detection
from hydrofdi.studies.run_lengths.judgement import RunLengths

if TYPE_CHECKING:
    from hydrofdi.report.contract import FigureKind

_LEAD = "Which leak is found, with which sensors and which score, at a stated rate of false alarms."


@dataclass(frozen=True)
class DetectionReport:
    """The report of a judged study, of simulated or measured records.

    Attributes
    ----------
    name : str
        Files are named after it.
    path : Path
        The file that it was made from.
    detections : tuple of Detection
        One for each design of the records; the sections show the first.
    varied : Varied
        What differs between the records.
    before, after : tuple of Block
        Further sections, such as what is missing, and provenance.
    progress : Progress or None
        How far the sweep is; None if all records are there from the start, as measured ones are.
    sensors : tuple of Sensor
        Those that are simulated for the scores.
    estimates : tuple of Estimates
        Estimates against the truth, for each design; empty if the truth is not known.
    run_lengths : tuple of RunLengths
        Control charts of each design; empty if none is asked for.
    has_results : bool
        Whether any record can be judged; otherwise the report says only what is missing.
    doubts : Block or None
        Verdicts on the records, such as unsettled; None if all are ok.
    """

    name: str
    path: Path
    detections: tuple[Detection, ...]
    varied: Varied = field(default_factory=Varied)
    before: tuple[Block | None, ...] = ()
    after: tuple[Block | None, ...] = ()
    progress: Progress | None = None
    sensors: tuple[Sensor, ...] = ()
    estimates: tuple[Estimates, ...] = ()
    run_lengths: tuple[RunLengths, ...] = ()
    has_results: bool = True
    doubts: Block | None = None

    @property
    def is_complete(self) -> bool:
        """Whether no record is still to come."""
        return self.progress is None or self.progress.is_complete

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        return "ranking"

    @property
    def _has_charts(self) -> bool:
        return any(each.charts for each in self.run_lengths)

    @property
    def _perfect(self) -> tuple[Sensor, ...]:
        return perfect_sensors(self.sensors, self.detections[0])

    def document(self) -> Document:
        """The sections of the report."""
        first = self.detections[0]
        missing = (None if self.progress is None else self.progress.block(), *self.before)
        if not self.has_results:
            return document_of(self.name, _LEAD, (*answers(*missing), *self.after))
        blocks = (
            *answers(
                *missing,
                answer_block(first, is_complete=self.is_complete, remark=perfect_sentence(self._perfect)),
            ),
            self.doubts,
            populations_block(first, self.varied, self.sensors),
            ranking_block(first),
            false_alarms_block(first),
            run_lengths_block(self.run_lengths[0]) if self._has_charts and self.is_complete else None,
            levels_block(first),
            estimates_block(self.estimates[0]) if self.estimates else None,
            why_block(first) if self.is_complete else None,
            designs_block(self.detections) if self.is_complete else None,
            caveats_block(first),
            *self.after,
        )
        return document_of(self.name, _LEAD, blocks)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "experiment": self.name,
            "is_complete": self.is_complete,
            "perfect_sensors": [each.symbol for each in self._perfect],
            **({} if self.progress is None else self.progress.record),
            "detection": [record for each in self.detections for record in detection_records(each)],
            "estimates": estimate_records(self.estimates),
            "run_lengths": run_length_records(self.run_lengths),
            "studies": [study_record(each) for each in self.detections],
            "designs": design_records(self.detections),
        }

    def columns(self) -> dict[str, list[Any]]:
        """Header → values, one line per score and tested population, and per chart, limit and population."""
        lines = [*detection_lines(self.detections), *run_length_lines(self.run_lengths)]
        headers = dict.fromkeys(header for line in lines for header in line)
        return {header: [line.get(header) for line in lines] for header in headers}

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure; none without results."""
        if not self.has_results:
            return {}
        from hydrofdi.report.figures.delays import run_length_figures
        from hydrofdi.report.figures.detection import detection_figures

        return detection_figures(self.detections[0]) | run_length_figures(self.run_lengths)

    def checks(self) -> dict[str, bool | None]:
        """Nothing: a study states no goals."""
        return {}
