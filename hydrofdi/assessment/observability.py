"""What the motion of an experiment tells the estimators among its indicators."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hydrofdi.estimation.observability import correlations, spectrum
from hydrofdi.execution import Job
from hydrofdi.indicators.information import Information, Informative
from hydrofdi.indicators.measuring import seen_by
from hydrofdi.records import Array, RecordBatch
from hydrofdi.simulation import simulate_batch
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period

LONGEST = 20.0
"""What is looked at of a record, from its start [s]."""

COLLINEAR = 0.95
"""Correlation from which on two unknowns are called collinear."""

_NOTABLE = 0.3
"""Parts of a direction that are named."""


@dataclass(frozen=True)
class KnownUnknown:
    """Standard deviations of an unknown before and after a record, in its SI unit, ``1`` for shares."""

    name: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True)
class Observability:
    """What a healthy record tells an estimator; empty if its estimate diverges along it.

    Attributes
    ----------
    indicator : str
        Its label.
    duration : float
        Of the record [s].
    singular_values : tuple of float
        Of the Gramian of states and parameters, in units of the deviations beforehand, the largest first:
        along its direction the record alone leaves 1/√s of them.
    condition : float
        The largest over the smallest; infinite if the record tells nothing of a direction.
    weakest : str
        The direction of the parameters that is known least behind the record.
    weakest_left : float
        Its deviation behind the record over that beforehand.
    unknowns : tuple of KnownUnknown
    collinear : tuple of (str, str, float)
        Pairs whose errors behind the record are correlated, and how.
    """

    indicator: str
    duration: float
    singular_values: tuple[float, ...]
    condition: float
    weakest: str
    weakest_left: float
    unknowns: tuple[KnownUnknown, ...]
    collinear: tuple[tuple[str, str, float], ...]


def observability(job: Job) -> tuple[Observability, ...]:
    """What a run without a leak, up to 20 s of it, tells each indicator that has unknowns.

    Parameters
    ----------
    job : Job
        A run; its K_i is left aside.
    """
    estimators = {
        label: each for label, each in job.analysis.indicators.items() if isinstance(each, Informative)
    }
    record = _healthy_record(job) if estimators else None
    if record is None:
        return ()
    return tuple(
        _described(label, record.duration, each.information(seen_by(each, record)))
        for label, each in estimators.items()
        if each.obstacle(record) is None
    )


def _healthy_record(job: Job) -> RecordBatch | None:
    """The start of a run without a leak; None if it fails."""
    parameters = job.parameters
    trajectory = simulate_batch([parameters], [0.0])
    if not trajectory.outcomes[0].is_ok:
        return None
    frequency, first = parameters.record.sampling_frequency, job.analysis.n_discarded
    whole = RecordBatch(
        {channel: getattr(trajectory, signal) for channel, signal in SIGNAL_OF_CHANNEL.items()},
        frequency,
        ("",),
        drive_period=drive_period(parameters.input, parameters.load.random_force),
    )
    return whole.window(first, first + round(LONGEST * frequency))


def _described(label: str, duration: float, found: Information) -> Observability:
    if not np.isfinite([found.gramian, found.covariance]).all():
        return Observability(label, duration, (), math.nan, "", math.nan, (), ())
    parameters = slice(found.n_motion, None)
    told, left = spectrum(found.gramian), spectrum(found.covariance[parameters, parameters])
    shares = np.sqrt(np.diag(found.covariance))
    return Observability(
        label,
        duration,
        tuple(told.values.tolist()),
        told.condition,
        _in_words(left.directions[0], [each.name for each in found.unknowns[parameters]]),
        math.sqrt(left.values[0]),
        tuple(
            KnownUnknown(each.name, each.unit, float(each.deviation), float(each.deviation * share))
            for each, share in zip(found.unknowns, shares, strict=True)
        ),
        tuple(_collinear(found)),
    )


def _in_words(direction: Array, names: list[str]) -> str:
    parts = sorted(zip(names, direction.tolist(), strict=True), key=lambda part: -abs(part[1]))
    return ", ".join(f"{name} {share:.2f}" for name, share in parts if abs(share) >= _NOTABLE)


def _collinear(found: Information) -> Iterator[tuple[str, str, float]]:
    correlated = correlations(found.covariance)
    for (i, one), (j, other) in combinations(enumerate(found.unknowns), 2):
        if abs(correlated[i, j]) > COLLINEAR:
            yield one.name, other.name, float(correlated[i, j])
