"""What the motion of an experiment tells the estimators among its indicators."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hydrofdi.estimation.observability import correlations, spectrum
from hydrofdi.execution import Job
from hydrofdi.indicators.information import Information, Informative
from hydrofdi.indicators.measuring import seen_by
from hydrofdi.records import RecordBatch
from hydrofdi.simulation import simulate_batch
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period

LONGEST, COLLINEAR, _NOTABLE = 20.0, 0.95, 0.3
"""What is looked at of a record [s]; correlation of collinear unknowns; parts of a direction with a name."""


@dataclass(frozen=True)
class KnownUnknown:
    """Standard deviations of an unknown before and after a record, in its SI unit, ``1`` for shares."""

    name: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True)
class Observability:
    """What a healthy record of a duration [s] tells an estimator; empty if its estimate diverges along it.

    `singular_values` of the Gramian of states and parameters are in units of the deviations beforehand, the
    largest first: along its direction the record alone leaves 1/√s of them. `weakest` is the direction of the
    parameters that is known least, and `weakest_left` its deviation over that beforehand. `collinear` lists
    pairs whose errors behind the record are correlated.
    """

    indicator: str
    duration: float
    singular_values: tuple[float, ...] = ()
    condition: float = math.nan
    weakest: str = ""
    weakest_left: float = math.nan
    unknowns: tuple[KnownUnknown, ...] = ()
    collinear: tuple[tuple[str, str, float], ...] = ()


def observability(job: Job) -> tuple[Observability, ...]:
    """What a run without a leak, up to 20 s of it, tells each indicator that has unknowns."""
    made, run = job.analysis.indicators, job.parameters
    estimators = {label: each for label, each in made.items() if isinstance(each, Informative)}
    if not estimators or not (trajectory := simulate_batch([run], [0.0])).outcomes[0].is_ok:
        return ()
    frequency, first = run.record.sampling_frequency, job.analysis.n_discarded
    signals = {channel: getattr(trajectory, signal) for channel, signal in SIGNAL_OF_CHANNEL.items()}
    period = drive_period(run.input, run.load.random_force)
    record = RecordBatch(signals, frequency, ("",), drive_period=period)
    record = record.window(first, first + round(LONGEST * frequency))
    return tuple(
        _described(label, record.duration, each.information(seen_by(each, record)))
        for label, each in estimators.items()
        if each.obstacle(record) is None
    )


def _described(label: str, duration: float, found: Information) -> Observability:
    if not np.isfinite([found.gramian, found.covariance]).all():
        return Observability(label, duration)
    parameters, unknowns = slice(found.n_motion, None), found.unknowns
    told, left = spectrum(found.gramian), spectrum(found.covariance[parameters, parameters])
    names = (each.name for each in unknowns[parameters])
    weakest = sorted(zip(names, left.directions[0].tolist(), strict=True), key=lambda part: -abs(part[1]))
    correlated = correlations(found.covariance)
    shares = np.sqrt(np.diag(found.covariance))
    return Observability(
        label,
        duration,
        tuple(told.values.tolist()),
        told.condition,
        ", ".join(f"{name} {share:.2f}" for name, share in weakest if abs(share) >= _NOTABLE),
        math.sqrt(left.values[0]),
        tuple(
            KnownUnknown(each.name, each.unit, float(each.deviation), float(each.deviation * share))
            for each, share in zip(unknowns, shares, strict=True)
        ),
        tuple(
            (unknowns[i].name, unknowns[j].name, float(correlated[i, j]))
            for i, j in combinations(range(len(unknowns)), 2)
            if abs(correlated[i, j]) > COLLINEAR
        ),
    )
