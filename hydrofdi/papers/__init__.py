"""Papers whose studies hydrofdi repeats: one package each, with what their reports add."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hydrofdi.report.composition import Report
from hydrofdi.store.experiment_data import ExperimentData

if TYPE_CHECKING:
    from hydrofdi.report.document import ComposedReport


def make_report(data: ExperimentData) -> ComposedReport:
    """The report of an experiment: of a study of detection, of a paper's study, else the general one.

    Within `shown_in`, people read it in the units that the experiment is written in.
    """
    if data.experiment.study is not None:
        from hydrofdi.report.detection.report import report_study

        return report_study(data)
    if data.experiment.paper:
        from hydrofdi.papers.maddahi2015.report import StudyReport

        return StudyReport(data)
    return Report(data)
