"""Claims and the sealed alarm of every scenario over the start phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.claims import Margin, claim_margins
from hydrofdi.papers.maddahi2015.controls import alarm_matrix
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.papers.maddahi2015.standings import phase_grids, settled_grid
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ScenarioPhases:
    """One way to look at the records of all scenarios.

    Attributes
    ----------
    margins : dict
        Claim → margin at the configured phase, or of the settled record [percentage points], (n_scenario,).
    phase_margins : dict
        Claim → margin at each start phase, (n_phase, n_scenario).
    alarms : ndarray of bool, shape (n_scenario, n_raised)
        Whether the d3 rule alarms on the sealed actuator at each β above the normal one.
    phase_alarms : ndarray of bool, shape (n_phase, n_scenario, n_raised)
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
        """Scenarios in which the d3 rule alarms at every β above the normal one."""
        return np.asarray(self.alarms.all(axis=1))

    @property
    def alarms_throughout(self) -> Mask:
        """Scenarios in which it does so at every start phase."""
        return np.asarray(self.phase_alarms.all(axis=(0, 2)))

    def held(self, claims: tuple[str, ...]) -> Mask:
        """Scenarios in which all of these claims hold."""
        with np.errstate(invalid="ignore"):
            mask: Mask = np.logical_and.reduce([self.margins[claim] > 0.0 for claim in claims])
        return mask

    def phases_held(self, claims: tuple[str, ...]) -> NDArray[np.int64]:
        """Number of phases in which all of these claims hold, shape (n_scenario,)."""
        with np.errstate(invalid="ignore"):
            held = np.logical_and.reduce([self.phase_margins[claim] > 0.0 for claim in claims])
        counts: NDArray[np.int64] = held.sum(axis=0)
        return counts


def scenario_phases(grid: ModeGrid, data: ExperimentData) -> tuple[ScenarioPhases, ScenarioPhases | None]:
    """All scenarios as configured, and of the settled records; None if no run has settled features.

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


def _measured(grid: ModeGrid, phases: tuple[ModeGrid, ...]) -> ScenarioPhases:
    margins = [claim_margins(phase) for phase in phases]
    return ScenarioPhases(
        margins=claim_margins(grid),
        phase_margins={claim: np.stack([margin[claim] for margin in margins]) for claim in margins[0]},
        alarms=alarm_matrix(grid),
        phase_alarms=np.stack([alarm_matrix(phase) for phase in phases]),
    )
