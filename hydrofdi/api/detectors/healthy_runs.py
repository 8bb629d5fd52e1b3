"""Which runs of an experiment are healthy: known from the runs themselves, not from any label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.config import expand_runs
from hydrofdi.config.run_table.expansion import study_roles
from hydrofdi.config.study.table import StudyTable
from hydrofdi.evaluation.populations import Kind
from hydrofdi.records import RecordSource
from hydrofdi.report.runs import external_coefficients
from hydrofdi.store.records import StoredRecords
from hydrofdi.studies.reading import stored_roles

_EXTERNAL = ("external_coefficient", "external_coefficient_1", "external_coefficient_2")

Runs = NDArray[np.intp]


@dataclass(frozen=True)
class HealthyRuns:
    """The healthy runs of an experiment: of a study its healthy fit records; else all without a leak.

    Attributes
    ----------
    source : RecordSource
        Only these.
    n_left_out : int
        Number of the other runs.
    is_study : bool
    """

    source: RecordSource
    n_left_out: int
    is_study: bool


def healthy_simulated(source: SimulatedRecords) -> HealthyRuns:
    """Those of an experiment that is simulated."""
    experiment, runs = source.experiment, expand_runs(source.experiment).runs
    if experiment.study is not None:
        healthy = _fit(study_roles(experiment))
    else:
        flows, coefficients = (runs.values(f"leakage.internal_{name}") for name in ("flow", "coefficient"))
        internal = [flow or coefficient for flow, coefficient in zip(flows, coefficients, strict=True)]
        external = zip(*(runs.values(f"leakage.{name}") for name in _EXTERNAL), strict=True)
        healthy = _sealed(internal, list(external))
    only = replace(source, only=healthy.tolist())
    return HealthyRuns(only, len(runs) - healthy.size, experiment.study is not None)


def healthy_stored(source: StoredRecords) -> HealthyRuns:
    """Those of an experiment that is stored.

    Raises
    ------
    ReportError
        Its file does not contain the runs of its study.
    """
    data = source.data
    if data.experiment.study is not None:
        healthy = _fit(stored_roles(data))
    else:
        healthy = _sealed(data.leakage_requests.tolist(), external_coefficients(data))
    only = replace(source, only=healthy.tolist())
    return HealthyRuns(only, data.n_run - healthy.size, data.experiment.study is not None)


def _fit(roles: StudyTable) -> Runs:
    are_fit = [each.kind is Kind.HEALTHY and each.is_fit for each in roles.populations]
    return np.flatnonzero(np.array(are_fit)[roles.of_run])


def _sealed(internal: Sequence[Any], external: Sequence[Sequence[Any]]) -> Runs:
    leaks = [bool(inner) or any(outer) for inner, outer in zip(internal, external, strict=True)]
    return np.flatnonzero(~np.array(leaks, dtype=bool))
