"""How a conclusion depends on what is not known: claims and controls over the scenarios of an ensemble."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.claims import CLAIMS, Margin
from hydrofdi.papers.maddahi2015.controls import best_level_matrix
from hydrofdi.papers.maddahi2015.grid.modes import ABSENT, ModeGrid
from hydrofdi.papers.maddahi2015.scenarios.phases import ScenarioPhases, scenario_phases
from hydrofdi.papers.maddahi2015.scenarios.values import ValueShare, value_shares
from hydrofdi.quality.doubts import DOUBTS
from hydrofdi.report.intervals import Share, clustered_share
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.store.results import MISSING

Mask = NDArray[np.bool_]
"""One truth value per scenario."""

CORE = ("C1", "C2", "C3", "C4")
"""The claims that carry the paper's conclusion."""


@dataclass(frozen=True)
class ScenarioStudy:
    """Claims and controls over all scenarios.

    Attributes
    ----------
    grid : ModeGrid
    outcomes : tuple of str, length n_scenario
        ``ok`` where all runs of a scenario succeeded, else the status of the first that did not.
    configured : ScenarioPhases
        Claims and sealed alarms of the records as configured.
    settled : ScenarioPhases or None
        The same of the settled records; None if no run has settled features.
    best_levels : ndarray of int, shape (n_scenario, n_mode)
        Position of the best level of each leaky mode under the matched baseline; −1 if there is none.
    doubts : dict
        Word of a verdict → the scenarios with a run that it was given to, shape (n_scenario,).
    draws : ndarray of int, shape (n_scenario,)
        The draw of the sample that a scenario was made from; those of one draw depend on each other.
    is_drawn : bool
        Whether scenarios are drawn independently (``method: random``), so that shares have an interval.
    """

    grid: ModeGrid
    outcomes: tuple[str, ...]
    configured: ScenarioPhases
    settled: ScenarioPhases | None
    best_levels: NDArray[np.int64]
    doubts: dict[str, Mask]
    draws: NDArray[np.int64]
    is_drawn: bool

    @property
    def margins(self) -> dict[str, Margin]:
        """Claim → margin in every scenario, as configured [percentage points]."""
        return self.configured.margins

    @property
    def alarms(self) -> Mask:
        """Whether the d3 rule alarms on the sealed actuator at each β above the normal one, as configured."""
        return self.configured.alarms

    @property
    def sound(self) -> Mask:
        """Feasible scenarios without a doubtful run."""
        doubtful = np.logical_or.reduce([np.zeros_like(self.feasible), *self.doubts.values()])
        sound: Mask = self.feasible & ~doubtful
        return sound

    def share(self, outcomes: NDArray[np.bool_], members: Mask) -> Share:
        """Share of outcomes among some scenarios; `outcomes` has shape (n_scenario, ...)."""
        kept = outcomes[members]
        per_scenario = kept.size // max(1, len(kept))
        return clustered_share(kept.ravel(), np.repeat(self.draws[members], per_scenario))

    @property
    def n_scenario(self) -> int:
        """Number of different scenarios."""
        return len(self.outcomes)

    @cached_property
    def feasible(self) -> Mask:
        """Scenarios of which all runs succeeded."""
        return np.array([outcome == "ok" for outcome in self.outcomes])

    @property
    def obstacles(self) -> dict[str, int]:
        """Status → number of scenarios that it made infeasible, or that are not computed yet."""
        return dict(sorted(Counter(outcome for outcome in self.outcomes if outcome != "ok").items()))

    def reproducing(self, claims: tuple[str, ...]) -> Mask:
        """Feasible scenarios in which all of these claims hold."""
        mask: Mask = self.feasible & self.configured.held(claims)
        return mask

    def decided(self, claims: tuple[str, ...]) -> Mask:
        """Feasible scenarios that say whether all of these claims hold: they do, or one of them does not."""
        with np.errstate(invalid="ignore"):
            failed = [self.margins[claim] <= 0.0 for claim in claims]
        mask: Mask = self.feasible & np.logical_or.reduce(failed)
        return mask | self.reproducing(claims)

    def is_open(self, claims: tuple[str, ...]) -> bool:
        """Whether one of these claims cannot be tested in any feasible scenario, and none fails in all."""
        untested = [np.isnan(self.margins[claim][self.feasible]).all() for claim in claims]
        return any(untested) and not np.array_equal(self.decided(claims), self.feasible)

    @property
    def claim_sets(self) -> dict[str, tuple[str, ...]]:
        """Name → claims: each by itself, then together."""
        single = {claim.id: (claim.id,) for claim in CLAIMS}
        every = tuple(single)
        return single | {"C1–C4": CORE, "C1–C5": every[:5], "C1–C6": every}

    @cached_property
    def value_shares(self) -> tuple[ValueShare, ...]:
        """The scenarios by the values of each parameter."""
        return value_shares(self.grid)


def study_scenarios(grid: ModeGrid, data: ExperimentData) -> ScenarioStudy:
    """Evaluate claims and controls in every scenario.

    Parameters
    ----------
    grid : ModeGrid
        Made from `data`.
    data : ExperimentData
        An experiment with an ``ensemble``.
    """
    statuses = np.asarray(data.columns[names.STATUS]).astype(str)
    outcomes = tuple(_outcome(statuses, positions) for positions in grid.positions)
    configured, settled = scenario_phases(grid, data)
    sample = data.experiment.ensemble.sample
    return ScenarioStudy(
        grid=grid,
        outcomes=outcomes,
        configured=configured,
        settled=settled,
        best_levels=best_level_matrix(grid),
        doubts=_doubts(data, grid),
        draws=_draws(data, grid),
        is_drawn=sample is not None and sample.method == "random",
    )


def _doubts(data: ExperimentData, grid: ModeGrid) -> dict[str, Mask]:
    verdicts = np.asarray(data.columns[names.VERDICT]).astype(str)
    doubts: dict[str, Mask] = {}
    for word in DOUBTS:
        found = np.char.find(verdicts, word) >= 0
        in_scenario = (found[grid.positions] & (grid.positions != ABSENT)).any(axis=(1, 2))
        if in_scenario.any():
            doubts[word] = in_scenario
    return doubts


def _draws(data: ExperimentData, grid: ModeGrid) -> NDArray[np.int64]:
    """Scenarios that agree in all sampled parameters are of one draw."""
    sample = data.experiment.ensemble.sample
    if sample is None:
        return np.arange(len(grid.scenarios))
    places: dict[tuple[Any, ...], int] = {}
    keys = [tuple(scenario[name] for name in sample.over) for scenario in grid.scenarios]
    return np.array([places.setdefault(key, len(places)) for key in keys])


def _outcome(statuses: NDArray[Any], positions: NDArray[np.int64]) -> str:
    found = [str(statuses[position]) for position in positions.ravel() if position != ABSENT]
    bad = [status for status in found if status != "ok"]
    return MISSING if MISSING in bad else next(iter(bad), "ok")
