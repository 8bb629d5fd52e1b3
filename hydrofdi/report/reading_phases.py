"""Claims and the sealed alarm of every reading over the start phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.claims import Margin, claim_margins
from hydrofdi.report.controls import alarm_matrix
from hydrofdi.report.modes import ModeGrid
from hydrofdi.report.phases import phase_grids, settled_grid
from hydrofdi.store import ExperimentData, names

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ReadingPhases:
    """One way to look at the records of all readings.

    Attributes
    ----------
    margins : dict
        Claim → margin at the configured phase, or of the settled record [percentage points], (n_reading,).
    phase_margins : dict
        Claim → margin at each start phase, (n_phase, n_reading).
    alarms : ndarray of bool, shape (n_reading, n_raised)
        Whether the d3 rule alarms on the sealed actuator at each β above the normal one.
    phase_alarms : ndarray of bool, shape (n_phase, n_reading, n_raised)
        The same at each start phase.
    """

    margins: dict[str, Margin]
    phase_margins: dict[str, NDArray[np.float64]]
    alarms: Mask
    phase_alarms: Mask

    @property
    def n_phase(self) -> int:
        """Number of start phases that were measured."""
        return len(self.phase_alarms)

    @property
    def alarms_everywhere(self) -> Mask:
        """Readings in which the d3 rule alarms at every β above the normal one."""
        return np.asarray(self.alarms.all(axis=1))

    @property
    def alarms_throughout(self) -> Mask:
        """Readings in which it does so at every start phase."""
        return np.asarray(self.phase_alarms.all(axis=(0, 2)))

    def held(self, claims: tuple[str, ...]) -> Mask:
        """Readings in which all of these claims hold."""
        with np.errstate(invalid="ignore"):
            mask: Mask = np.logical_and.reduce([self.margins[claim] > 0.0 for claim in claims])
        return mask

    def phases_held(self, claims: tuple[str, ...]) -> NDArray[np.int64]:
        """Number of phases in which all of these claims hold, shape (n_reading,)."""
        with np.errstate(invalid="ignore"):
            held = np.logical_and.reduce([self.phase_margins[claim] > 0.0 for claim in claims])
        counts: NDArray[np.int64] = held.sum(axis=0)
        return counts


def reading_phases(grid: ModeGrid, data: ExperimentData) -> tuple[ReadingPhases, ReadingPhases | None]:
    """All readings as configured, and of the settled records; None where no run has settled features.

    Parameters
    ----------
    grid : ModeGrid
        Made from `data`.
    data : ExperimentData
    """
    settled = settled_grid(grid, data)
    configured = _measured(grid, phase_grids(grid, data, names.PHASE_DETAIL_RMS))
    if settled is None:
        return configured, None
    return configured, _measured(settled, phase_grids(settled, data, names.SETTLED_PHASE_DETAIL_RMS))


def _measured(grid: ModeGrid, phases: tuple[ModeGrid, ...]) -> ReadingPhases:
    margins = [claim_margins(phase) for phase in phases]
    return ReadingPhases(
        margins=claim_margins(grid),
        phase_margins={claim: np.stack([margin[claim] for margin in margins]) for claim in margins[0]},
        alarms=alarm_matrix(grid),
        phase_alarms=np.stack([alarm_matrix(phase) for phase in phases]),
    )
