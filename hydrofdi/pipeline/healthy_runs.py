"""Which runs of an experiment are healthy: known from the runs themselves, not from any label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import expand_runs
from hydrofdi.config.run_table.expansion import study_roles
from hydrofdi.config.study.table import StudyTable
from hydrofdi.evaluation.populations import Kind
from hydrofdi.pipeline.simulated import SimulatedRecords
from hydrofdi.report.runs.changes import external_coefficients
from hydrofdi.store.records import StoredRecords
from hydrofdi.studies.reading import stored_roles

_EXTERNAL = ("external_coefficient", "external_coefficient_1", "external_coefficient_2")

Runs = NDArray[np.intp]


def healthy_simulated(source: SimulatedRecords) -> tuple[SimulatedRecords, int]:
    """The healthy runs of an experiment, and how many runs are left out.

    Of a study they are the healthy fit population; else all without a leak.
    """
    runs = expand_runs(source.experiment).runs
    if source.experiment.study is not None:
        healthy = _fit(study_roles(source.experiment))
    else:
        flows, coefficients = (runs.values(f"leakage.internal_{name}") for name in ("flow", "coefficient"))
        internal = [flow or coefficient for flow, coefficient in zip(flows, coefficients, strict=True)]
        external = zip(*(runs.values(f"leakage.{name}") for name in _EXTERNAL), strict=True)
        healthy = _sealed(internal, list(external))
    return replace(source, only=healthy.tolist()), len(runs) - healthy.size


def healthy_stored(source: StoredRecords) -> tuple[StoredRecords, int]:
    """The same of stored runs."""
    data = source.data
    if data.experiment.study is not None:
        healthy = _fit(stored_roles(data))
    else:
        healthy = _sealed(data.leakage_requests.tolist(), external_coefficients(data))
    return replace(source, only=healthy.tolist()), data.n_run - healthy.size


def _fit(roles: StudyTable) -> Runs:
    are_fit = [each.kind is Kind.HEALTHY and each.is_fit for each in roles.populations]
    return np.flatnonzero(np.array(are_fit)[roles.of_run])


def _sealed(internal: Sequence[Any], external: Sequence[Sequence[Any]]) -> Runs:
    leaks = [bool(inner) or any(outer) for inner, outer in zip(internal, external, strict=True)]
    return np.flatnonzero(~np.array(leaks, dtype=bool))
