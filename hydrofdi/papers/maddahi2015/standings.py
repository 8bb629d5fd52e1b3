"""How conclusions stand over the start phases, and in the settled records.

The decimated transform keeps every 2^j-th coefficient, so that what it says depends on the sample that the
record starts at. A conclusion from one phase is none: here each is counted over all of them. Settled records
are measured by the undecimated transform, free of boundaries; its mean square is the mean over the phases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.claims import D3, claim_margins
from hydrofdi.papers.maddahi2015.controls import BestLevel, SealedAlarm
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid, gathered
from hydrofdi.report.runs import Levels, baseline_changes, largest_positive
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names

Changes = NDArray[np.float64]
"""δ [%]."""


@dataclass(frozen=True)
class PhaseCount:
    """In how many start phases something holds, and the numbers behind it.

    Attributes
    ----------
    held, of : int
        Phases in which it holds, and in which it is decided.
    values : tuple of float
        The number that decides, phase by phase [percentage points]; NaN if it is not decided.
    """

    held: int
    of: int
    values: tuple[float, ...]

    @property
    def least(self) -> float:
        """The smallest number; NaN if there is none."""
        return float(np.nanmin(self.values)) if self.of else float("nan")

    @property
    def mean(self) -> float:
        """Their mean; NaN if there is none."""
        return float(np.nanmean(self.values)) if self.of else float("nan")

    @property
    def largest(self) -> float:
        """The largest of the numbers; NaN if there is none."""
        return float(np.nanmax(self.values)) if self.of else float("nan")


@dataclass(frozen=True)
class Standing:
    """How claims and controls stand in one way to look at the records.

    Attributes
    ----------
    title : str
        The way, in words.
    n_phase : int
        Number of start phases that were measured.
    claims : dict
        Claim → margin [percentage points] over the phases; it holds if it does so in all scenarios.
    margins : dict
        Claim → margin at the configured phase, or of the settled records [percentage points]; the least of
        all scenarios.
    alarms : tuple of PhaseCount
        δd3 [%] of each sealed run above the normal EBM over the phases; it holds if the d3 rule alarms.
    alarm_deltas : tuple of tuple of float
        δ [%] of all levels of these runs, as of `margins`.
    best_levels : tuple of PhaseCount
        δ [%] of the best level of each leaky run against the matched baseline over the phases; it holds if
        the level is the best one there as well.
    """

    title: str
    n_phase: int
    claims: dict[str, PhaseCount]
    margins: dict[str, float]
    alarms: tuple[PhaseCount, ...]
    alarm_deltas: tuple[Levels, ...]
    best_levels: tuple[PhaseCount, ...]


def settled_grid(grid: ModeGrid, data: ExperimentData) -> ModeGrid | None:
    """δ of the settled records, the mean over the phases; None if no run has settled features."""
    if np.isnan(data.columns[names.SETTLED_DETAIL_RMS]).all():
        return None
    return _with_changes(grid, baseline_changes(data, names.SETTLED_DETAIL_RMS))


def phase_grids(grid: ModeGrid, data: ExperimentData, name: str) -> tuple[ModeGrid, ...]:
    """δ at each start phase, from a variable over phases; `grid` alone if there is none."""
    if name not in data.columns:
        return (grid,)
    fixed, matched = baseline_changes(data, name)
    return tuple(_with_changes(grid, (fixed[:, phase], matched[:, phase])) for phase in range(fixed.shape[1]))


def standings(
    grid: ModeGrid,
    data: ExperimentData,
    alarms: Sequence[SealedAlarm],
    best_levels: Sequence[BestLevel],
    scenarios: Sequence[int] | None = None,
) -> tuple[Standing, ...]:
    """How an experiment stands as configured, and in the settled records if there are any.

    Parameters
    ----------
    grid : ModeGrid
        Made from `data`.
    data : ExperimentData
    alarms, best_levels : sequence of SealedAlarm, of BestLevel
        The controls as configured.
    scenarios : sequence of int, optional
        Positions of the scenarios that claims look at; by default all.
    """
    settled = settled_grid(grid, data)
    variables = [("as configured", grid, names.DETAIL_RMS, names.PHASE_DETAIL_RMS)]
    if settled is not None:
        variables.append(("settled", settled, names.SETTLED_DETAIL_RMS, names.SETTLED_PHASE_DETAIL_RMS))
    kept = list(range(len(grid.scenarios)) if scenarios is None else scenarios)
    found = []
    for title, of_view, variable, over_phases in variables:
        phases = phase_grids(of_view, data, over_phases)
        margins = [_least_margins(phase, kept) for phase in phases]
        fixed, matched = baseline_changes(data, over_phases if over_phases in data.columns else variable)
        sealed = [alarm.position for alarm in alarms]
        shown = baseline_changes(data, variable)[0][sealed]
        found.append(
            Standing(
                title=title,
                n_phase=len(phases),
                claims={claim: _counted([margin[claim] for margin in margins]) for claim in margins[0]},
                margins=_least_margins(of_view, kept),
                alarms=tuple(_level_count(_by_phase(fixed[position]), D3) for position in sealed),
                alarm_deltas=tuple(map(tuple, shown.tolist())),
                best_levels=tuple(
                    _level_count(_by_phase(matched[mode.position]), mode.level) for mode in best_levels
                ),
            )
        )
    return tuple(found)


def _least_margins(grid: ModeGrid, scenarios: list[int]) -> dict[str, float]:
    return {
        claim: float(np.min(margin[scenarios])) if scenarios else float("nan")
        for claim, margin in claim_margins(grid).items()
    }


def _by_phase(changes: Changes) -> Changes:
    """δ of a run, (n_phase, n_level), whether it was measured at one phase or at all."""
    return np.atleast_2d(changes)


def _level_count(deltas: Changes, level: int | None) -> PhaseCount:
    """In how many phases a level has the largest positive δ; `deltas` has shape (n_phase, n_level)."""
    known = np.isfinite(deltas).all(axis=1)
    best = [largest_positive(levels) == level for levels in deltas[known].tolist()]
    values = deltas[:, level] if level is not None else np.full(len(deltas), np.nan)
    return PhaseCount(sum(best), int(known.sum()), tuple(values.tolist()))


def _counted(margins: Sequence[float]) -> PhaseCount:
    held = sum(margin > 0.0 for margin in margins)
    return PhaseCount(held, int(np.isfinite(margins).sum()), tuple(margins))


def _with_changes(grid: ModeGrid, changes: tuple[Changes, Changes]) -> ModeGrid:
    fixed, matched = (gathered(change, grid.positions) for change in changes)
    return replace(grid, fixed=fixed, matched=matched)
