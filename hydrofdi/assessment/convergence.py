"""How short the step must be for the features to converge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hydrofdi.assessment.selection import computed_rows
from hydrofdi.execution import Job

MOST_HALVINGS = 6


@dataclass(frozen=True)
class Convergence:
    """Features under halved steps.

    Attributes
    ----------
    tolerance : float
        Largest relative change that is accepted [-].
    steps : tuple of float
        The steps tried, longest first [s].
    changes : tuple of tuple of float
        For every step, the largest relative change of each detail RMS over the runs when it is halved; NaN
        where a run failed.
    """

    tolerance: float
    steps: tuple[float, ...]
    changes: tuple[tuple[float, ...], ...]

    @property
    def good_enough(self) -> float | None:
        """The longest step tried whose halving moves no feature beyond the tolerance; None: none of them."""
        for step, change in zip(self.steps, self.changes, strict=True):
            if max(change) <= self.tolerance:
                return step
        return None


def converge(jobs: Sequence[Job], tolerance: float) -> Convergence:
    """Halve the step of runs until none of their detail RMS moves by more than a tolerance."""
    steps: list[float] = []
    changes: list[tuple[float, ...]] = []
    coarse = _detail_rms(jobs)
    for _ in range(MOST_HALVINGS):
        steps.append(jobs[0].parameters.record.step)
        jobs = [_with_half_step(job) for job in jobs]
        fine = _detail_rms(jobs)
        changes.append(tuple(np.max(np.abs(coarse / fine - 1.0), axis=0).tolist()))
        coarse = fine
        if max(changes[-1]) <= tolerance:
            break
    return Convergence(tolerance, tuple(steps), tuple(changes))


def _with_half_step(job: Job) -> Job:
    half = {"record.step": 0.5 * job.parameters.record.step}
    return replace(job, parameters=job.parameters.with_values(half))


def _detail_rms(jobs: Sequence[Job]) -> NDArray[np.float64]:
    return np.array([row["detail_rms"] for row in computed_rows(jobs)])
