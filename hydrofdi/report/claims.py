"""The sentences of the paper as checks, and whether an experiment reproduces them.

A check is a number of percentage points, its *margin*: how far a single δ that it looks at could move before
it turns. It holds where the margin is above zero. Where the margin is a difference of two δ, both may move at
once, and half of it is enough: that is its *allowance*. q1 < q2 < q3 are the leakages, β0 is the normal EBM.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.modes import Mode, ModeGrid
from hydrofdi.store import ExperimentData, names

Margin = NDArray[np.float64]
"""Percentage points, shape (n_reading,); NaN where a run is missing or failed, or the healthy is still."""

D2, D3 = 1, 2
"""Positions of the two levels that the sentences speak of."""


@dataclass(frozen=True)
class Check:
    """One check of a claim.

    Attributes
    ----------
    modes : tuple of Mode
        What it looks at.
    size : ndarray, shape (n_reading,), or None
        How far a δ is on the right side of zero [percentage points].
    lead : ndarray, shape (n_reading,), or None
        How far one δ is on the right side of another [percentage points].
    """

    modes: tuple[Mode, ...]
    size: Margin | None = None
    lead: Margin | None = None

    @property
    def margin(self) -> Margin:
        """How far a single δ may move before the check turns."""
        return _least(self.size, self.lead)

    @property
    def allowance(self) -> Margin:
        """How far every δ may move at once before the check turns."""
        return _least(self.size, None if self.lead is None else 0.5 * self.lead)


def _least(first: Margin | None, second: Margin | None) -> Margin:
    known = [margin for margin in (first, second) if margin is not None]
    least: Margin = np.minimum.reduce(known)
    return least


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper.

    Attributes
    ----------
    id : str
        C1 … C6.
    sentence : str
        What the paper says.
    rule : str
        What is checked.
    checks : callable
        Grid → the checks that it allows.
    """

    id: str
    sentence: str
    rule: str
    checks: Callable[[ModeGrid], list[Check]]


@dataclass(frozen=True)
class CheckResult:
    """A check of one reading: the modes and runs behind it, margin and allowance (NaN: not to be decided)."""

    reading: int
    modes: tuple[Mode, ...]
    run_ids: tuple[str, ...]
    margin: float
    allowance: float

    @property
    def holds(self) -> bool | None:
        """Whether it holds; None where that is not to be decided."""
        return None if self.margin != self.margin else self.margin > 0.0


@dataclass(frozen=True)
class Verdict:
    """A claim and what an experiment says of it."""

    claim: Claim
    checks: tuple[CheckResult, ...]

    @property
    def reproduced(self) -> bool | None:
        """Whether all checks hold; None where that is not decided, or there is nothing to check."""
        outcomes = [check.holds for check in self.checks]
        if False in outcomes:
            return False
        return True if outcomes and None not in outcomes else None

    @property
    def margin(self) -> float:
        """The least margin of the checks that are decided; NaN where there is none."""
        known = [check.margin for check in self.checks if check.holds is not None]
        return min(known, default=float("nan"))

    @property
    def allowance(self) -> float:
        """The least allowance of the checks that are decided; NaN where there is none."""
        known = [check.allowance for check in self.checks if check.holds is not None]
        return min(known, default=float("nan"))


def _leads(mode: Mode, delta: NDArray[np.float64], level: int) -> Check:
    """One level above zero and above all others; `delta` has shape (n_reading, n_level)."""
    others = np.delete(delta, level, axis=-1)
    return Check((mode,), size=delta[:, level], lead=delta[:, level] - others.max(axis=-1))


def _d2_is_most_sensitive(grid: ModeGrid) -> list[Check]:
    modes = grid.modes(bulk_modulus=grid.normal)
    return [_leads(mode, grid.leaky[:, mode[0], mode[1]], D2) for mode in modes]


def _d2_grows_with_leakage(grid: ModeGrid) -> list[Check]:
    modes = grid.modes(bulk_modulus=grid.normal)
    if len(modes) < 2:
        return []
    delta = grid.leaky[:, [q for q, _ in modes], grid.normal, D2]
    return [Check(tuple(modes), lead=np.diff(delta, axis=1).min(axis=1))]


def _d2_falls_with_bulk_modulus(grid: ModeGrid) -> list[Check]:
    checks = []
    for leakage in range(len(grid.leakage_flows)):
        modes = grid.modes(leakage=leakage)
        if len(modes) > 1:
            delta = grid.leaky[:, leakage, [b for _, b in modes], D2]
            checks.append(Check(tuple(modes), lead=-np.diff(delta, axis=1).max(axis=1)))
    return checks


def _d3_leads_above_normal(grid: ModeGrid) -> list[Check]:
    modes = [mode for mode in grid.modes() if mode[1] > grid.normal]
    return [_leads(mode, grid.leaky[:, mode[0], mode[1]], D3) for mode in modes]


def _d3_alone_is_positive(grid: ModeGrid) -> list[Check]:
    modes = [mode for mode in grid.modes(leakage=0) if mode[1] > grid.normal] if grid.leakage_flows else []
    deltas = [grid.leaky[:, q, b] for q, b in modes]
    sizes = [np.minimum(d[:, D3], -np.delete(d, D3, axis=-1).max(axis=-1)) for d in deltas]
    return [Check((mode,), size=size) for mode, size in zip(modes, sizes, strict=True)]


def _no_level_is_always_largest(grid: ModeGrid) -> list[Check]:
    modes = grid.modes()
    if len(modes) < 2:
        return []
    size = np.abs(np.stack([grid.leaky[:, q, b] for q, b in modes], axis=1))
    shortfalls = [
        (np.delete(size, level, axis=-1).max(axis=-1) - size[..., level]).max(axis=1)
        for level in range(grid.n_level)
    ]
    return [Check(tuple(modes), lead=np.min(shortfalls, axis=0))]


CLAIMS = (
    Claim(
        "C1",
        "At normal EBM d2 is the most sensitive coefficient.",
        "at β0, for each leakage: δd2 > 0 and the largest",
        _d2_is_most_sensitive,
    ),
    Claim(
        "C2",
        "At normal EBM δd2 grows with leakage.",
        "at β0: δd2(q1) < δd2(q2) < δd2(q3)",
        _d2_grows_with_leakage,
    ),
    Claim(
        "C3",
        "For a given leakage δd2 falls as EBM rises.",
        "for each leakage: δd2 strictly decreasing over β",
        _d2_falls_with_bulk_modulus,
    ),
    Claim(
        "C4",
        "Above normal EBM d3 has the most positive sensitivity.",
        "for each leakage and each β > β0: δd3 > 0 and the largest",
        _d3_leads_above_normal,
    ),
    Claim(
        "C5",
        "With the small leakage and EBM above normal, δd3 is the only positive one.",
        "for q1 and each β > β0: δd3 > 0, all others < 0",
        _d3_alone_is_positive,
    ),
    Claim(
        "C6",
        "Absolute values lead to no conclusion.",
        "the level with the largest abs(δ) is not the same in all leaky modes",
        _no_level_is_always_largest,
    ),
)
"""All claims, in their order."""


def judge_claims(
    grid: ModeGrid, data: ExperimentData, readings: Sequence[int] | None = None
) -> tuple[Verdict, ...]:
    """The verdict on every claim: it is reproduced where it holds in all readings that are looked at.

    Parameters
    ----------
    grid : ModeGrid
        Its modes; with fewer than three levels there is nothing to check.
    data : ExperimentData
        The experiment that the grid was made from.
    readings : sequence of int, optional
        Positions of the readings to look at; by default all.
    """
    readings = range(len(grid.readings)) if readings is None else readings
    return tuple(Verdict(claim, _results(claim, grid, data, readings)) for claim in CLAIMS)


def claim_margins(grid: ModeGrid) -> dict[str, Margin]:
    """Claim → its margin in every reading, the least of its checks; NaN where it is not decided."""
    margins = {claim.id: [check.margin for check in _checks(claim, grid)] for claim in CLAIMS}
    undecided = np.full(len(grid.readings), np.nan)
    return {name: np.min(found, axis=0) if found else undecided for name, found in margins.items()}


def _checks(claim: Claim, grid: ModeGrid) -> list[Check]:
    return claim.checks(grid) if grid.n_level > D3 else []


def _results(
    claim: Claim, grid: ModeGrid, data: ExperimentData, readings: Sequence[int]
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
        for r in readings
    )


def _run_ids(grid: ModeGrid, data: ExperimentData, reading: int, modes: tuple[Mode, ...]) -> tuple[str, ...]:
    """The healthy run that δ is taken against, then the leaky runs."""
    leaky = [int(grid.positions[reading, 1 + q, b]) for q, b in modes]
    healthy = int(data.fixed_baseline[leaky[0]])
    return tuple(str(data.columns[names.RUN_ID][position]) for position in (healthy, *leaky))
