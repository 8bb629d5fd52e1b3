"""Papers whose studies hydrofdi repeats: one package each, with what their reports add."""

from __future__ import annotations

from hydrofdi.papers.maddahi2015 import asked_views
from hydrofdi.report.analysis import analyze
from hydrofdi.report.composition import Report
from hydrofdi.report.document import ComposedReport
from hydrofdi.store import ExperimentData


def make_report(data: ExperimentData) -> ComposedReport:
    """The report of an experiment: of a study of detection, of a paper's study, else the general one.

    Within `shown_in`, people read it in the units that the experiment is written in.
    """
    experiment = data.experiment
    if experiment.study is not None:
        from hydrofdi.report.detection.report import report_study

        return report_study(data)
    if experiment.paper:
        from hydrofdi.papers.maddahi2015.report import StudyReport

        return StudyReport.of(data)
    analysis = analyze(data)
    return Report(analysis, tuple(asked_views(analysis)))
