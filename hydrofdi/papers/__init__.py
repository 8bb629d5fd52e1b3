"""Papers whose studies hydrofdi repeats: a room each, with what their reports add."""

from __future__ import annotations

from hydrofdi.papers.maddahi2015 import StudyReport, is_study
from hydrofdi.report import Report, analyze
from hydrofdi.store import ExperimentData


def make_report(data: ExperimentData) -> Report:
    """The report of an experiment: that of a paper where it is the study of one, else the general one."""
    return StudyReport.of(data) if is_study(data.experiment) else Report(analyze(data))
