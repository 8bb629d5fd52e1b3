"""Whether an experiment reproduces the sentences of the paper, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.papers.maddahi2015.claims.catalogue import CLAIMS, Claim
from hydrofdi.papers.maddahi2015.claims.checks import D3, Check, Margin
from hydrofdi.papers.maddahi2015.grid.modes import Mode, ModeGrid
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names


@dataclass(frozen=True)
class CheckResult:
    """A check of one scenario: the modes and runs behind it, margin and allowance (NaN: undecided)."""

    scenario: int
    modes: tuple[Mode, ...]
    run_ids: tuple[str, ...]
    margin: float
    allowance: float

    @property
    def holds(self) -> bool | None:
        """Whether it holds; None if that is not to be decided."""
        return None if self.margin != self.margin else self.margin > 0.0


@dataclass(frozen=True)
class ClaimResult:
    """A claim and what an experiment says of it."""

    claim: Claim
    checks: tuple[CheckResult, ...]

    @property
    def reproduced(self) -> bool | None:
        """Whether all checks hold; None if that is not decided, or there is nothing to check."""
        outcomes = [check.holds for check in self.checks]
        if False in outcomes:
            return False
        return True if outcomes and None not in outcomes else None

    @property
    def margin(self) -> float:
        """The smallest margin of the checks that are decided; NaN if there is none."""
        known = [check.margin for check in self.checks if check.holds is not None]
        return min(known, default=float("nan"))

    @property
    def allowance(self) -> float:
        """The smallest allowance of the checks that are decided; NaN if there is none."""
        known = [check.allowance for check in self.checks if check.holds is not None]
        return min(known, default=float("nan"))


def evaluate_claims(
    grid: ModeGrid, data: ExperimentData, scenarios: Sequence[int] | None = None
) -> tuple[ClaimResult, ...]:
    """The result of every claim: it is reproduced if it holds in all scenarios that are looked at.

    Parameters
    ----------
    grid : ModeGrid
        Its modes; with fewer than three levels there is nothing to check.
    data : ExperimentData
        The experiment that the grid was made from.
    scenarios : sequence of int, optional
        Positions of the scenarios to look at; by default all.
    """
    scenarios = range(len(grid.scenarios)) if scenarios is None else scenarios
    return tuple(ClaimResult(claim, _results(claim, grid, data, scenarios)) for claim in CLAIMS)


def claim_margins(grid: ModeGrid) -> dict[str, Margin]:
    """Claim → its margin in every scenario, the smallest of its checks; NaN if it is not decided."""
    margins = {claim.id: [check.margin for check in _checks(claim, grid)] for claim in CLAIMS}
    undecided = np.full(len(grid.scenarios), np.nan)
    return {name: np.min(found, axis=0) if found else undecided for name, found in margins.items()}


def _checks(claim: Claim, grid: ModeGrid) -> list[Check]:
    return claim.checks(grid) if grid.n_level > D3 else []


def _results(
    claim: Claim, grid: ModeGrid, data: ExperimentData, scenarios: Sequence[int]
) -> tuple[CheckResult, ...]:
    return tuple(
        CheckResult(
            r,
            check.modes,
            _run_ids(grid, data, r, check.modes),
            float(check.margin[r]),
            float(check.allowance[r]),
        )
        for check in _checks(claim, grid)
        for r in scenarios
    )


def _run_ids(grid: ModeGrid, data: ExperimentData, scenario: int, modes: tuple[Mode, ...]) -> tuple[str, ...]:
    """The healthy run that δ is taken against, then the leaky runs."""
    leaky = [int(grid.positions[scenario, 1 + q, b]) for q, b in modes]
    healthy = int(data.fixed_baseline[leaky[0]])
    return tuple(str(data.columns[names.RUN_ID][position]) for position in (healthy, *leaky))
