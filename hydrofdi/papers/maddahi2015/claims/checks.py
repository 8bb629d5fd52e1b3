"""What the sentences of the paper come to as numbers: the checks behind each claim.

A check is a number of percentage points, its *margin*: how far a single δ that it looks at could move before
it turns. It holds if the margin is above zero. Where the margin is a difference of two δ, both may move at
once, and half of it is enough: that is its *allowance*. q1 < q2 < q3 are the leakages, β0 is the normal EBM.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.grid.modes import Mode, ModeGrid

Margin = NDArray[np.float64]
"""Percentage points, shape (n_scenario,); NaN if a run is missing or failed, or the healthy is still."""

D2, D3 = 1, 2
"""Positions of the two levels that the sentences are about."""


@dataclass(frozen=True)
class Check:
    """One check of a claim.

    Attributes
    ----------
    modes : tuple of Mode
        What it looks at.
    size : ndarray, shape (n_scenario,), or None
        How far a δ is on the right side of zero [percentage points].
    lead : ndarray, shape (n_scenario,), or None
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


def _leads(mode: Mode, delta: NDArray[np.float64], level: int) -> Check:
    """One level above zero and above all others; `delta` has shape (n_scenario, n_level)."""
    others = np.delete(delta, level, axis=-1)
    return Check((mode,), size=delta[:, level], lead=delta[:, level] - others.max(axis=-1))


def d2_is_most_sensitive(grid: ModeGrid) -> list[Check]:
    """δd2 is above zero and the largest, at the normal EBM, for each leakage."""
    modes = grid.modes(bulk_modulus=grid.normal)
    return [_leads(mode, grid.leaky[:, mode[0], mode[1]], D2) for mode in modes]


def d2_grows_with_leakage(grid: ModeGrid) -> list[Check]:
    """δd2 grows with the leakage, at the normal EBM."""
    modes = grid.modes(bulk_modulus=grid.normal)
    if len(modes) < 2:
        return []
    delta = grid.leaky[:, [q for q, _ in modes], grid.normal, D2]
    return [Check(tuple(modes), lead=np.diff(delta, axis=1).min(axis=1))]


def d2_falls_with_bulk_modulus(grid: ModeGrid) -> list[Check]:
    """δd2 falls as the EBM rises, for each leakage."""
    checks = []
    for leakage in range(len(grid.leakage_flows)):
        modes = grid.modes(leakage=leakage)
        if len(modes) > 1:
            delta = grid.leaky[:, leakage, [b for _, b in modes], D2]
            checks.append(Check(tuple(modes), lead=-np.diff(delta, axis=1).max(axis=1)))
    return checks


def d3_leads_above_normal(grid: ModeGrid) -> list[Check]:
    """δd3 is above zero and the largest, for each leakage and EBM above normal."""
    modes = [mode for mode in grid.modes() if mode[1] > grid.normal]
    return [_leads(mode, grid.leaky[:, mode[0], mode[1]], D3) for mode in modes]


def d3_alone_is_positive(grid: ModeGrid) -> list[Check]:
    """δd3 alone is above zero, with the smallest leakage, for each EBM above normal."""
    modes = [mode for mode in grid.modes(leakage=0) if mode[1] > grid.normal] if grid.leakage_flows else []
    deltas = [grid.leaky[:, q, b] for q, b in modes]
    sizes = [np.minimum(d[:, D3], -np.delete(d, D3, axis=-1).max(axis=-1)) for d in deltas]
    return [Check((mode,), size=size) for mode, size in zip(modes, sizes, strict=True)]


def no_level_is_always_largest(grid: ModeGrid) -> list[Check]:
    """The level with the largest abs(δ) differs between modes."""
    modes = grid.modes()
    if len(modes) < 2:
        return []
    size = np.abs(np.stack([grid.leaky[:, q, b] for q, b in modes], axis=1))
    shortfalls = [
        (np.delete(size, level, axis=-1).max(axis=-1) - size[..., level]).max(axis=1)
        for level in range(grid.n_level)
    ]
    return [Check(tuple(modes), lead=np.min(shortfalls, axis=0))]
