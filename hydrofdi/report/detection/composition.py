"""The report of a stored study."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.detection.progress import Progress
from hydrofdi.report.detection.report import DetectionReport
from hydrofdi.report.detection.sensors import sensors_of
from hydrofdi.report.detection.varied import varied
from hydrofdi.report.document import Block
from hydrofdi.report.sections.provenance import provenance_block
from hydrofdi.report.sections.runs import remarks_block
from hydrofdi.report.sections.study_verdicts import verdicts_block
from hydrofdi.scoring import has_extra
from hydrofdi.settings.counting import counted
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout.names import MESSAGE, STATUS
from hydrofdi.store.results import MISSING
from hydrofdi.studies.estimates.judging import judge_estimates
from hydrofdi.studies.judged import judge_study
from hydrofdi.studies.left_out import asks_for_extra
from hydrofdi.studies.run_lengths.reading import judge_run_lengths

_MOST = 20
"""Reasons that are listed one by one."""


def report_study(data: ExperimentData) -> DetectionReport:
    """Judge a stored study and report on it.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    """
    study = data.experiment.study
    assert study is not None
    detections = judge_study(data)
    return DetectionReport(
        data.experiment.name,
        data.path,
        detections,
        varied(study),
        before=(remarks_block(data), holes_block(data)),
        after=(provenance_block(_with_extra(data)),),
        progress=Progress(data.n_run - int((_statuses(data) == MISSING).sum()), data.n_run),
        sensors=sensors_of(data.experiment, detections[0]),
        estimates=judge_estimates(data),
        run_lengths=judge_run_lengths(data),
        has_results=bool((_statuses(data) == "ok").any()),
        doubts=verdicts_block(data),
    )


def _with_extra(data: ExperimentData) -> ExperimentData:
    """The same with the version of scikit-learn, where scores were made with it for this report."""
    if not (asks_for_extra(data.experiment.detection) and has_extra()):
        return data
    return replace(data, versions=data.versions | {"scikit-learn": version("scikit-learn")})


def _statuses(data: ExperimentData) -> NDArray[np.str_]:
    return np.asarray(data.columns[STATUS]).astype(str)


def holes_block(data: ExperimentData) -> Block | None:
    """How many of the computed runs have no numbers, and why; None if all have."""
    statuses = _statuses(data)
    rows = np.flatnonzero((statuses != "ok") & (statuses != MISSING))
    if not rows.size:
        return None
    kinds = ", ".join(f"{count:,} {status}" for status, count in Counter(statuses[rows].tolist()).items())
    messages = np.asarray(data.columns[MESSAGE]).astype(str)[rows].tolist()
    reasons = Counter(message for message in messages if message)
    lines = [f"{counted(count, 'run')}: {message}" for message, count in reasons.most_common(_MOST)]
    rest = len(reasons) - _MOST
    more = [f"… and {counted(rest, 'more reason')}."] if rest > 0 else []
    n_computed = int((statuses != MISSING).sum())
    first = (
        f"{rows.size:,} of {counted(n_computed, 'run')} have no results and are not counted in any "
        f"rate: {kinds}."
    )
    return Block("holes", "What is missing", (first, *lines, *more))
