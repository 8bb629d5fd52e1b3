"""The sentences of the paper as checks, and how they stand over start phases and in settled records.

A check is a number of percentage points, its *margin*: how far a single δ that it looks at could move before
it turns. It holds if the margin is above zero. q1 < q2 < q3 are the leakages, β0 is the normal EBM.

A *scenario* is one set of values of everything that varies besides leakage and EBM: an experiment without
such parameters has a single scenario, an ensemble has thousands. Checks are evaluated on all of them, and on
all start phases, at once. The sentences of the paper compare modes that share a leakage or an EBM; runs whose
leakage or EBM is drawn from a range share none and form no grid.

The decimated transform keeps every 2^j-th coefficient, so that what it says depends on the sample that the
record starts at. A conclusion from one phase is none: here each is counted over all of them. Settled records
are measured by the undecimated transform, free of boundaries; its mean square is the mean over the phases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.report import runs
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.results import external_coefficients

ABSENT = -1
"""Position of a run that the experiment does not ask for."""

_FEW_CELLS, _CELLS_PER_RUN = 10_000, 4
"""A grid has few cells in all, or few for each of its runs."""

D2, D3 = 1, 2
"""Positions of the two levels that the sentences are about."""

Mode = tuple[int, int]
"""Positions of a leakage and of an EBM in a grid."""

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ModeGrid:
    """The modes of an experiment over scenarios, leakages and EBM.

    Attributes
    ----------
    scenarios : tuple of dict
        Varied parameter → value in SI, for each scenario.
    leakage_flows : tuple of float
        Leakage levels [m³/s], ascending, without the sealed one; at the normal EBM where K_i itself is given.
    positions : ndarray of int, shape (n_scenario, 1 + n_leakage, n_bulk_modulus)
        Rows of the runs in the experiment, the sealed ones first; ``ABSENT`` if there is none.
    lack : str
        Why there are no modes to compare, as a sentence: it then holds a single run.
    """

    scenarios: tuple[dict[str, Any], ...]
    leakage_flows: tuple[float, ...]
    bulk_moduli: tuple[float, ...]
    normal: int
    positions: NDArray[np.int64]
    lack: str = ""

    def modes(self, leakage: int | None = None, bulk_modulus: int | None = None) -> list[Mode]:
        """The leaky modes that all scenarios contain; all, or those of one leakage or EBM."""
        planned = np.argwhere((self.positions[:, 1:] > ABSENT).all(axis=0)).tolist()
        return [(q, b) for q, b in planned if leakage in (None, q) and bulk_modulus in (None, b)]

    @property
    def raised(self) -> list[int]:
        """Positions of the β above the normal one."""
        return list(range(self.normal + 1, len(self.bulk_moduli)))

    def leaky(self, delta: runs.Array) -> runs.Array:
        """δ of all runs, (..., n_run, n_level), by scenario, leakage and EBM; NaN where a run is absent."""
        positions = self.positions[:, 1:]
        cells: runs.Array = np.where((positions == ABSENT)[..., None], np.nan, delta[..., positions, :])
        return cells


def leaks_out_more(data: ExperimentData) -> Mask:
    """Whether the chambers of each run leak more than those of its healthy run; scenarios count as they are.

    Modes are combinations of internal leakage and EBM; additional external leakage is another fault.
    """
    # −1 (no baseline) would index the last run; those rows are masked below.
    coefficients = external_coefficients(data)
    healthy = coefficients[np.maximum(data.matched_baseline, 0)]
    is_compared = (data.matched_baseline != names.NO_BASELINE) & (not data.experiment.has_scenarios)
    more: Mask = is_compared & (coefficients != healthy).any(axis=1)
    return more


def arrange_modes(data: ExperimentData) -> ModeGrid:
    """The grid of an experiment."""
    kept = np.flatnonzero(~leaks_out_more(data))
    scenarios, moduli, indices = _axes(data, kept)
    if lack := _lack(data, tuple(int(of_axis.max()) + 1 for of_axis in indices), len(kept)):
        kept = np.array([max(0, data.fixed_baseline[0])])
        scenarios, moduli, indices = _axes(data, kept)
    positions = np.full([int(of_axis.max()) + 1 for of_axis in indices], ABSENT)
    positions[indices] = kept
    # what differs in the leak alone, such as its law, is the same once the actuator is sealed
    for scenario, _, beta in np.argwhere(positions[:, :1] == ABSENT):
        leaky = positions[scenario, 1:, beta]
        if (leaky != ABSENT).any():
            positions[scenario, 0, beta] = data.matched_baseline[leaky[leaky != ABSENT][0]]
    normal = 0 if lack else moduli.index(runs.normal_bulk_modulus(data))
    planned = [(leaky[normal], *leaky[leaky != ABSENT]) for leaky in positions[0, 1:]]
    first = [next(row for row in rows if row != ABSENT) for rows in planned]
    flows = tuple(runs.ReportedRuns(data, np.array(first, dtype=int), ()).leakage_flows.tolist())
    return ModeGrid(tuple(scenarios), flows, tuple(moduli), normal, positions, lack)


def _axes(
    data: ExperimentData, kept: NDArray[np.int64]
) -> tuple[list[dict[str, Any]], list[float], tuple[NDArray[np.int64], ...]]:
    """Scenarios and β, and where runs lie: indices along scenario, leakage and EBM."""
    values = {
        name: np.array(data.values(name), dtype=object)[kept].tolist() for name in runs.label_names(data)
    }
    labels = [name for name in values if len(kept) == data.n_run or len(set(values[name])) > 1]
    rows = list(zip(*(values[name] for name in labels), strict=True)) or [()] * len(kept)
    order = {scenario: index for index, scenario in enumerate(dict.fromkeys(rows))}
    _, leakage = np.unique([0.0, *data.leakage_requests[kept]], return_inverse=True)
    moduli, modulus = np.unique(data.columns[names.BULK_MODULUS][kept], return_inverse=True)
    indices = (np.array([order[scenario] for scenario in rows]), leakage[1:], modulus)
    return [dict(zip(labels, each, strict=True)) for each in order], moduli.tolist(), indices


def _lack(data: ExperimentData, shape: tuple[int, ...], n_run: int) -> str:
    """Why an experiment has no grid of modes; empty if it has one."""
    if (data.fixed_baseline == names.NO_BASELINE).all():
        return "Without a healthy run to compare with, the claims are not evaluated."
    drawn = data.experiment.sweep.drawn | data.experiment.ensemble.drawn
    is_drawn = drawn & {"fluid.bulk_modulus", *INTERNAL_LEAKAGE_FORMS}
    if not is_drawn and np.prod(shape) <= max(_FEW_CELLS, _CELLS_PER_RUN * n_run):
        return ""
    return (
        "Leakage and EBM do not form a grid of modes: they are drawn from a range, or too few runs share"
        " them. The claims are not evaluated."
    )


Check = runs.Array
"""The margin of a check in each scenario [percentage points], shape (..., n_scenario).

NaN if a run is missing or failed, or does not move.
"""


def _leads(delta: runs.Array, modes: Iterable[Mode], level: int) -> list[Check]:
    """In each mode, one level above zero and above all others."""
    own = [delta[..., q, b, :] for q, b in modes]
    return [each[..., level] - np.delete(each, level, axis=-1).max(axis=-1, initial=0.0) for each in own]


def _d2_is_most_sensitive(grid: ModeGrid, delta: runs.Array) -> list[Check]:
    return _leads(delta, grid.modes(bulk_modulus=grid.normal), D2)


def _d2_grows_with_leakage(grid: ModeGrid, delta: runs.Array) -> list[Check]:
    modes = grid.modes(bulk_modulus=grid.normal)
    own = delta[..., [q for q, _ in modes], grid.normal, D2]
    return [np.diff(own).min(axis=-1)] if len(modes) > 1 else []


def _d2_falls_with_bulk_modulus(grid: ModeGrid, delta: runs.Array) -> list[Check]:
    by_leakage = [grid.modes(leakage=leakage) for leakage in range(len(grid.leakage_flows))]
    return [
        -np.diff(delta[..., leakage, [b for _, b in modes], D2]).max(axis=-1)
        for leakage, modes in enumerate(by_leakage)
        if len(modes) > 1
    ]


def _d3_leads_above_normal(grid: ModeGrid, delta: runs.Array) -> list[Check]:
    return _leads(delta, [mode for mode in grid.modes() if mode[1] > grid.normal], D3)


def _d3_alone_is_positive(grid: ModeGrid, delta: runs.Array) -> list[Check]:
    modes = [mode for mode in grid.modes(leakage=0) if mode[1] > grid.normal]
    own = [delta[..., q, b, :] for q, b in modes]
    return [np.minimum(each[..., D3], -np.delete(each, D3, axis=-1).max(axis=-1)) for each in own]


def _no_level_is_always_largest(grid: ModeGrid, delta: runs.Array) -> list[Check]:
    modes = grid.modes()
    if len(modes) < 2:
        return []
    # A level leads everywhere if it falls short in no mode.
    size = np.abs(np.stack([delta[..., q, b, :] for q, b in modes], axis=-2))
    shortfalls = [
        (np.delete(size, level, axis=-1).max(axis=-1) - size[..., level]).max(axis=-1)
        for level in range(size.shape[-1])
    ]
    return [np.min(shortfalls, axis=0)]


class Claim(NamedTuple):
    """A sentence of the paper, the rule that is checked, and the checks of δ of the leaky modes."""

    id: str
    sentence: str
    rule: str
    checks_of: Callable[[ModeGrid, runs.Array], list[Check]]

    def checks(self, grid: ModeGrid, delta: runs.Array) -> list[Check]:
        """The checks that a grid allows; none with fewer than three levels."""
        return self.checks_of(grid, grid.leaky(delta)) if delta.shape[-1] > D3 else []


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

    @property
    def reproduced(self) -> bool | None:
        """Whether all checks hold; None if that is not decided, or there is nothing to check."""
        if self.margin <= 0.0:
            return False
        is_open = any(np.isnan(each[self.scenarios]).any() for each in self.checks)
        return True if self.margin > 0.0 and not is_open else None

    @property
    def margin(self) -> float:
        """The smallest margin of the checks that are decided [percentage points]; NaN if there is none."""
        margins = [value for each in self.checks for value in each[self.scenarios].tolist()]
        return min((value for value in margins if not math.isnan(value)), default=math.nan)


def claim_margins(grid: ModeGrid, delta: runs.Array) -> dict[str, runs.Array]:
    """Claim → the smallest margin of its checks of δ, (..., n_run, n_level): (..., n_scenario).

    NaN where a claim is not decided.
    """
    checks = {claim.id: claim.checks(grid, delta) for claim in CLAIMS}
    undecided = np.full((*delta.shape[:-2], len(grid.scenarios)), np.nan)
    return {name: np.min(margins, axis=0) if margins else undecided for name, margins in checks.items()}


def alarms(delta: runs.Array) -> Mask:
    """Whether the d3 rule alarms: all δ are known, and δd3 is positive and the largest."""
    alarm: Mask = (runs.best_levels(delta) == D3) & np.isfinite(delta).all(axis=-1)
    return alarm


class PhaseCount(NamedTuple):
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

    `shown` is δ of all runs against the fixed baseline at the configured phase, or of the undecimated
    transform [%], shape (n_run, n_level); `fixed` is the same at each start phase, (n_phase, n_run, n_level).
    """

    title: str
    grid: ModeGrid
    shown: runs.Array
    fixed: runs.Array

    @cached_property
    def margins(self) -> dict[str, runs.Array]:
        """Claim → margin of what is shown [percentage points], shape (n_scenario,)."""
        return claim_margins(self.grid, self.shown)

    @cached_property
    def phase_margins(self) -> dict[str, runs.Array]:
        """Claim → margin at each start phase, shape (n_phase, n_scenario)."""
        return claim_margins(self.grid, self.fixed)

    @property
    def n_phase(self) -> int:
        """Number of start phases that were measured."""
        return len(self.fixed)

    def claim(self, claim: str, scenarios: Sequence[int]) -> PhaseCount:
        """How a claim stands; it holds if it does so in all of these scenarios."""
        margins = [self.margins[claim], *self.phase_margins[claim]]
        # The worst scenario decides; NaN, which min keeps, leaves the claim open.
        number, *values = [float(each[scenarios].min()) if len(scenarios) else math.nan for each in margins]
        held = sum(value > 0.0 for value in values)
        return PhaseCount(self.title, claim, held, int(np.isfinite(values).sum()), number, tuple(values))

    def alarm(self, name: str, run: int) -> PhaseCount:
        """Where the d3 rule alarms on a run, by δd3."""
        deltas, number = self.fixed[:, run], float(self.shown[run, D3])
        n_known, held = int(np.isfinite(deltas).all(axis=1).sum()), int(alarms(deltas).sum())
        return PhaseCount(self.title, name, held, n_known, number, tuple(deltas[:, D3].tolist()))

    def alarms(self, fixed: runs.Array) -> Mask:
        """Whether the d3 rule alarms on the sealed actuator at each β above the normal one.

        `fixed` has shape (..., n_run, n_level), the result (..., n_scenario, n_raised).
        """
        sealed = self.grid.positions[:, 0, self.grid.raised]
        alarm: Mask = alarms(fixed[..., sealed, :]) & (sealed != ABSENT)
        return alarm

    @property
    def alarms_everywhere(self) -> dict[str, Mask]:
        """Scenarios in which it does so at every such β; and at every start phase, too."""
        here, throughout = self.alarms(self.shown).all(axis=1), self.alarms(self.fixed).all(axis=(0, 2))
        return {"alarms": np.asarray(here), "alarms_in_all_phases": np.asarray(throughout)}

    def held(self, claims: Sequence[str]) -> Mask:
        """Scenarios in which all of these claims hold."""
        return np.all([self.margins[claim] > 0.0 for claim in claims], axis=0)  # type: ignore[no-any-return]

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
        shown = phases = runs.baseline_changes(data, variable)["fixed"]
        if over_phases in data.columns:
            phases = np.moveaxis(runs.baseline_changes(data, over_phases)["fixed"], 1, 0)
        yield Standing(title, grid, shown, phases if phases.ndim > shown.ndim else shown[None])
