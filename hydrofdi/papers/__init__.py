"""Papers whose studies hydrofdi repeats: one package each, with what their reports add."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from hydrofdi.report.composition import Report
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.store.shards import Columns

if TYPE_CHECKING:
    from hydrofdi.report.table import ComposedReport


def make_report(data: ExperimentData) -> ComposedReport:
    """The report of an experiment: of a study of detection, of a paper's study, else the general one.

    Within `shown_in`, people read it in the units that the experiment is written in.
    """
    experiment = data.experiment
    if experiment.study is not None:
        from hydrofdi.report.detection.report import report_study

        # results never run the FMU that they name
        is_own = data.experiment.plant.fmu is None
        return report_study(data, partial(nominal_signals, data) if is_own else None)
    if experiment.paper:
        from hydrofdi.papers.maddahi2015.report import StudyReport

        return StudyReport(data)
    return Report(data)


def nominal_signals(data: ExperimentData, coefficients: Sequence[float]) -> Columns:
    """What the sensors of the nominal actuator of an experiment show, a row for each leakage coefficient."""
    from hydrofdi.sensing import measured_batch

    runs = [data.experiment.nominal_parameters.parameters] * len(coefficients)
    return measured_batch(runs, list(coefficients)).signals((names.TIME, *names.SIGNALS))
