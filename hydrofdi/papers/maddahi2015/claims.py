"""The sentences of the paper as checks, and how they stand over start phases and in settled records.

A check is a number of percentage points, its *margin*: how far a single δ that it looks at could move before
it turns. It holds if the margin is above zero. Where the margin is a difference of two δ, both may move at
once, and half of it is enough: that is its *allowance*. q1 < q2 < q3 are the leakages, β0 is the normal EBM.

The decimated transform keeps every 2^j-th coefficient, so that what it says depends on the sample that the
record starts at. A conclusion from one phase is none: here each is counted over all of them. Settled records
are measured by the undecimated transform, free of boundaries; its mean square is the mean over the phases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.grid import ABSENT, Mode, ModeGrid
from hydrofdi.report.runs import Array, baseline_changes, best_levels
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names

D2, D3 = 1, 2
"""Positions of the two levels that the sentences are about."""


class Check(NamedTuple):
    """A check: the modes that it looks at, and in each scenario its margin and its allowance.

    Both in percentage points, shape (n_scenario,); NaN if a run is missing or failed, or does not move.
    """

    modes: tuple[Mode, ...]
    margin: Array
    allowance: Array


def _check(modes: Iterable[Mode], size: Array | float = np.inf, lead: Array | float = np.inf) -> Check:
    """How far a δ is on the right side of zero, or of another δ."""
    return Check(tuple(modes), np.minimum(size, lead), np.minimum(size, 0.5 * lead))


def _leads(grid: ModeGrid, mode: Mode, level: int) -> Check:
    """One level above zero and above all others."""
    delta = grid.leaky[:, mode[0], mode[1]]
    others = np.delete(delta, level, axis=-1)
    return _check([mode], delta[:, level], delta[:, level] - others.max(axis=-1))


def _d2_is_most_sensitive(grid: ModeGrid) -> list[Check]:
    return [_leads(grid, mode, D2) for mode in grid.modes(bulk_modulus=grid.normal)]


def _d2_grows_with_leakage(grid: ModeGrid) -> list[Check]:
    modes = grid.modes(bulk_modulus=grid.normal)
    delta = grid.leaky[:, [q for q, _ in modes], grid.normal, D2]
    return [_check(modes, lead=np.diff(delta, axis=1).min(axis=1))] if len(modes) > 1 else []


def _d2_falls_with_bulk_modulus(grid: ModeGrid) -> list[Check]:
    checks = []
    for leakage in range(len(grid.leakage_flows)):
        modes = grid.modes(leakage=leakage)
        if len(modes) > 1:
            delta = grid.leaky[:, leakage, [b for _, b in modes], D2]
            checks.append(_check(modes, lead=-np.diff(delta, axis=1).max(axis=1)))
    return checks


def _d3_leads_above_normal(grid: ModeGrid) -> list[Check]:
    return [_leads(grid, mode, D3) for mode in grid.modes() if mode[1] > grid.normal]


def _d3_alone_is_positive(grid: ModeGrid) -> list[Check]:
    modes = [mode for mode in grid.modes(leakage=0) if mode[1] > grid.normal]
    deltas = [grid.leaky[:, q, b] for q, b in modes]
    sizes = [np.minimum(d[:, D3], -np.delete(d, D3, axis=-1).max(axis=-1)) for d in deltas]
    return [_check([mode], size) for mode, size in zip(modes, sizes, strict=True)]


def _no_level_is_always_largest(grid: ModeGrid) -> list[Check]:
    modes = grid.modes()
    if len(modes) < 2:
        return []
    size = np.abs(np.stack([grid.leaky[:, q, b] for q, b in modes], axis=1))
    shortfalls = [
        (np.delete(size, level, axis=-1).max(axis=-1) - size[..., level]).max(axis=1)
        for level in range(grid.n_level)
    ]
    return [_check(modes, lead=np.min(shortfalls, axis=0))]


class Claim(NamedTuple):
    """A sentence of the paper, the rule that is checked, and the checks that a grid allows."""

    id: str
    sentence: str
    rule: str
    checks_of: Callable[[ModeGrid], list[Check]]

    def checks(self, grid: ModeGrid) -> list[Check]:
        """The checks; none with fewer than three levels."""
        return self.checks_of(grid) if grid.n_level > D3 else []


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


@dataclass(frozen=True)
class ClaimResult:
    """A claim and what the scenarios that are looked at say of it: it is reproduced if it holds in all."""

    claim: Claim
    checks: list[Check]
    scenarios: Sequence[int]

    def _decided(self, quantity: str) -> Array:
        """Margins or allowances of all checks that are decided."""
        found = [getattr(check, quantity)[self.scenarios] for check in self.checks]
        numbers = np.concatenate(found) if found else np.empty(0)
        return numbers[~np.isnan(numbers)]

    @property
    def reproduced(self) -> bool | None:
        """Whether all checks hold; None if that is not decided, or there is nothing to check."""
        margins = self._decided("margin")
        if (margins <= 0.0).any():
            return False
        return True if 0 < margins.size == len(self.checks) * len(self.scenarios) else None

    @property
    def margin(self) -> float:
        """The smallest margin of the checks that are decided; NaN if there is none."""
        return min(self._decided("margin").tolist(), default=float("nan"))

    @property
    def allowance(self) -> float:
        """The smallest allowance of the checks that are decided; NaN if there is none."""
        return min(self._decided("allowance").tolist(), default=float("nan"))


def claim_margins(grid: ModeGrid) -> dict[str, Array]:
    """Claim → its margin in every scenario, the smallest of its checks; NaN if it is not decided."""
    found = {claim.id: [check.margin for check in claim.checks(grid)] for claim in CLAIMS}
    undecided = np.full(len(grid.scenarios), np.nan)
    return {name: np.min(margins, axis=0) if margins else undecided for name, margins in found.items()}


def alarms(delta: Array) -> NDArray[np.bool_]:
    """Whether the d3 rule alarms: all δ are known, and δd3 is positive and the largest."""
    found: NDArray[np.bool_] = (best_levels(delta) == D3) & np.isfinite(delta).all(axis=-1)
    return found


Mask = NDArray[np.bool_]


class Outcome(NamedTuple):
    """In how many start phases something holds, of those that decide it.

    `number` decides it at the configured phase, or in the settled record [percentage points]; `values` at
    each start phase.
    """

    records: str
    name: str
    held: int
    of: int
    number: float
    values: tuple[float, ...]

    @property
    def spread(self) -> dict[str, float]:
        """The least, the mean and the largest of the numbers; NaN if there is none."""
        known = np.array(self.values)[np.isfinite(self.values)] if self.of else np.empty(0)
        spread = (known.min(), known.mean(), known.max()) if known.size else (math.nan,) * 3
        return {name: float(each) for name, each in zip(("least", "mean", "largest"), spread, strict=True)}

    def phases(self, quantity: str) -> dict[str, Any]:
        """The same for programs."""
        return {"held": self.held, "of": self.of, quantity: self.spread}


@dataclass(frozen=True)
class Standing:
    """One way to look at the records: as configured, or settled.

    `fixed` and `matched` are δ of all runs at each start phase [%], shape (n_phase, n_run, n_level); `grid`
    contains those of the configured phase, or of the undecimated transform, and `shown` the same of all runs.
    """

    title: str
    grid: ModeGrid
    shown: Array
    fixed: Array
    matched: Array
    margins: dict[str, Array]
    """Claim → margin [percentage points], shape (n_scenario,)."""
    phase_margins: dict[str, Array]
    """Claim → margin at each start phase, shape (n_phase, n_scenario)."""

    @property
    def n_phase(self) -> int:
        """Number of start phases that were measured."""
        return len(self.fixed)

    def claim(self, claim: str, scenarios: Sequence[int]) -> Outcome:
        """How a claim stands; it holds if it does so in all of these scenarios."""
        found = [self.margins[claim], *self.phase_margins[claim]]
        number, *values = [float(each[scenarios].min()) if len(scenarios) else math.nan for each in found]
        held = sum(value > 0.0 for value in values)
        return Outcome(self.title, claim, held, int(np.isfinite(values).sum()), number, tuple(values))

    def level(self, name: str, deltas: Array, level: int, number: float = math.nan) -> Outcome:
        """Where a level has the largest positive δ of a run; `deltas` has shape (n_phase, n_level)."""
        known = deltas[np.isfinite(deltas).all(axis=1)]
        held = int((best_levels(known) == level).sum()) if len(known) else 0
        values = np.full(len(deltas), math.nan) if level < 0 else deltas[:, level]
        return Outcome(self.title, name, held, len(known), number, tuple(values.tolist()))

    def alarms(self, fixed: Array) -> Mask:
        """Whether the d3 rule alarms on the sealed actuator at each β above the normal one.

        `fixed` has shape (..., n_run, n_level), the result (..., n_scenario, n_raised).
        """
        sealed = self.grid.positions[:, 0, self.grid.raised]
        found: Mask = alarms(fixed[..., sealed, :]) & (sealed != ABSENT)
        return found

    @property
    def alarms_everywhere(self) -> dict[str, Mask]:
        """Scenarios in which it does so at every such β; and at every start phase, too."""
        here, throughout = self.alarms(self.shown).all(axis=1), self.alarms(self.fixed).all(axis=(0, 2))
        return {"alarms": np.asarray(here), "alarms_in_all_phases": np.asarray(throughout)}

    def held(self, claims: Sequence[str]) -> Mask:
        """Scenarios in which all of these claims hold."""
        return np.asarray(np.all([self.margins[claim] > 0.0 for claim in claims], axis=0))

    def phases_held(self, claims: Sequence[str]) -> NDArray[np.int64]:
        """Number of phases in which all of these claims hold, shape (n_scenario,)."""
        held = np.all([self.phase_margins[claim] > 0.0 for claim in claims], axis=0)
        return np.asarray(held.sum(axis=0))


def standings(grid: ModeGrid, data: ExperimentData) -> Iterator[Standing]:
    """How an experiment stands as configured, and in the settled records if there are any."""
    for title, variable, over_phases in (
        ("as configured", names.DETAIL_RMS, names.PHASE_DETAIL_RMS),
        ("settled", names.SETTLED_DETAIL_RMS, names.SETTLED_PHASE_DETAIL_RMS),
    ):
        if title == "settled" and np.isnan(data.columns[variable]).all():
            return
        own = baseline_changes(data, variable)
        fixed, matched = (
            (np.moveaxis(each, 1, 0) for each in baseline_changes(data, over_phases).values())
            if over_phases in data.columns
            else (each[None] for each in own.values())
        )
        of_view = grid.holding(**own)
        margins = [claim_margins(grid.holding(*phase)) for phase in zip(fixed, matched, strict=True)]
        over = {claim: np.stack([margin[claim] for margin in margins]) for claim in margins[0]}
        yield Standing(title, of_view, own["fixed"], fixed, matched, claim_margins(of_view), over)
