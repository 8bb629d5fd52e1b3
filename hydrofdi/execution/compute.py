"""The work of one task: simulate a batch of runs or read their records, measure them, write their shard."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.experiment import StoreConfig
from hydrofdi.execution.measuring import Job, measured_columns, needed_signals
from hydrofdi.indicators.measuring import Seconds
from hydrofdi.quality.doubts import how_records_settle
from hydrofdi.quality.measures import assess_runs, hydraulic_mode, mean_external_leakage_flows
from hydrofdi.sensing import Measurement
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.trajectory import Outcome, Trajectory
from hydrofdi.store.layout import names
from hydrofdi.store.shard import read_records, write_shard
from hydrofdi.units import convert

Columns = dict[str, NDArray[Any]]


Simulation = Callable[..., Trajectory]
"""What turns runs and their K_i into signals, while a tap reads them."""


@dataclass(frozen=True)
class Batch:
    """Jobs that share duration, step and sampling, and where and how they are stored.

    Either all records are to be simulated, or all are stored.
    """

    jobs: tuple[Job, ...]
    directory: Path
    store: StoreConfig

    @property
    def is_stored(self) -> bool:
        """Whether the records are stored and only measured."""
        return self.jobs[0].stored is not None


@dataclass(frozen=True)
class BatchReceipt:
    """What a finished batch says of itself.

    Attributes
    ----------
    n_run, n_failed : int
        Number of its runs, and of those that did not end well.
    shard : Path
        Where they are stored.
    seconds : dict
        Label of an indicator → CPU time that it took [s].
    """

    n_run: int
    n_failed: int
    shard: Path
    seconds: Seconds = field(default_factory=dict)


def compute_shard(batch: Batch) -> BatchReceipt:
    """Measure the records of a batch, simulated or stored, and write its shard.

    Raises
    ------
    StoreError
        The shard cannot be written, or a record cannot be read.
    """
    seconds: Seconds = {}
    compute = measure_stored if batch.is_stored else compute_columns
    columns = compute(batch.jobs, seconds=seconds)
    store = batch.store.model_copy(update={"signals": "none"}) if batch.is_stored else batch.store
    shard = write_shard(batch.directory, columns, store)
    n_failed = sum(status != "ok" for status in columns[names.STATUS])
    return BatchReceipt(len(batch.jobs), n_failed, shard, seconds)


def compute_columns(
    jobs: Sequence[Job], simulate: Simulation = simulate_batch, *, seconds: Seconds | None = None
) -> Columns:
    """All variables of a shard, one row per job, and the time axis.

    Jobs that differ in nothing but the analysis of their record are simulated once. CPU times [s] of their
    indicators are added to `seconds` by label.
    """
    recorded, record_of_job = _distinct_records(jobs)
    records = _simulated(recorded, simulate)
    if len(recorded) < len(jobs):
        records = {
            name: values if name == names.TIME else values[record_of_job] for name, values in records.items()
        }
    return records | _identities(jobs) | measured_columns(jobs, records, seconds)


def measure_stored(jobs: Sequence[Job], *, seconds: Seconds | None = None) -> Columns:
    """The same of jobs whose records are stored, signals left out; nothing is simulated."""
    places = [job.stored for job in jobs if job.stored is not None]
    wanted = set().union(*(needed_signals(job.analysis.indicators) for job in jobs))
    records = read_records(places, wanted, jobs[0].parameters.record.n_sample)
    return dict(records) | _identities(jobs) | measured_columns(jobs, records, seconds)


def _identities(jobs: Sequence[Job]) -> Columns:
    return {
        names.RUN_ID: np.array([job.run_id for job in jobs], dtype=object),
        names.RECORD_ID: np.array([job.record_id for job in jobs], dtype=object),
    }


def _distinct_records(jobs: Sequence[Job]) -> tuple[list[Job], list[int]]:
    """One job for each record that has to be simulated, and the place of each job's record among them."""
    if analysed_alike(jobs):
        return list(jobs), list(range(len(jobs)))
    keys = [(job.parameters.text(), job.leakage_coefficient.hex()) for job in jobs]
    first = dict(zip(reversed(keys), reversed(jobs), strict=True))
    places = {key: place for place, key in enumerate(dict.fromkeys(keys))}
    return [first[key] for key in places], [places[key] for key in keys]


def analysed_alike(jobs: Sequence[Job]) -> bool:
    """Whether jobs differ in more than the analysis of their record, so that each has a record of its own."""
    return all(job.analysis == jobs[0].analysis for job in jobs)


def _simulated(jobs: Sequence[Job], simulate: Simulation) -> Columns:
    """Records: what the sensors show, and what is known of the plant itself."""
    parameters = [job.parameters for job in jobs]
    coefficients = np.array([job.leakage_coefficient for job in jobs], dtype=float)
    sensors = Measurement(parameters)
    trajectory = simulate(parameters, np.nan_to_num(coefficients).tolist(), tap=sensors)
    trajectory = replace(trajectory, leakage_coefficient=coefficients, outcomes=_outcomes(jobs, trajectory))
    measured = sensors.show(trajectory)
    with np.errstate(all="ignore"):
        numbers = _plant_numbers(parameters, trajectory)
        settlings = how_records_settle(parameters, trajectory.chamber_1_pressure)
        quality = assess_runs(parameters, trajectory, measured, settlings, numbers[names.MODE_DAMPING_RATIO])
    failed = np.array([not outcome.is_ok for outcome in trajectory.outcomes])
    for values in numbers.values():
        values[failed] = np.nan
    return {
        names.STATUS: np.array([outcome.status for outcome in trajectory.outcomes], dtype=object),
        names.MESSAGE: np.array([outcome.message for outcome in trajectory.outcomes], dtype=object),
        names.LEAKAGE_COEFFICIENT: trajectory.leakage_coefficient,
        names.TIME: trajectory.time,
        **{name: getattr(measured, name) for name in names.SIGNALS},
        **numbers,
        **quality,
    }


def _outcomes(jobs: Sequence[Job], trajectory: Trajectory) -> tuple[Outcome, ...]:
    return tuple(
        _unreachable(job.parameters) if math.isnan(job.leakage_coefficient) else outcome
        for job, outcome in zip(jobs, trajectory.outcomes, strict=True)
    )


def _unreachable(parameters: RunParameters) -> Outcome:
    flow = convert(parameters.leakage.internal_flow or 0.0, "L/min")
    return Outcome("unreachable_leakage", f"no K_i gives a mean leakage of {flow:.4g} L/min")


def _plant_numbers(
    parameters: Sequence[RunParameters], trajectory: Trajectory
) -> dict[str, NDArray[np.float64]]:
    """What is known of the plant itself, over the whole record."""
    modes = [hydraulic_mode(run, trajectory, row) for row, run in enumerate(parameters)]
    external = mean_external_leakage_flows(parameters, trajectory)
    numbers = {
        **dict(zip(names.EXTERNAL_LEAKAGE_FLOWS, external, strict=True)),
        names.MEAN_LEAKAGE_FLOW: trajectory.mean_internal_leakage_flow,
        names.MODE_FREQUENCY: np.array([mode.frequency for mode in modes]),
        names.MODE_DAMPING_RATIO: np.array([mode.damping_ratio for mode in modes]),
    }
    for variable in names.EXTREMES:
        signal, _, kind = variable.name.rpartition("_")
        values = getattr(trajectory, signal)
        numbers[variable.name] = values.min(axis=1) if kind == "min" else values.max(axis=1)
    return numbers
