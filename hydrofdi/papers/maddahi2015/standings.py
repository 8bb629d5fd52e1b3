"""How conclusions stand over the start phases, and in the settled records.

The decimated transform keeps every 2^j-th coefficient, so that what it says depends on the sample that the
record starts at. A conclusion from one phase is none: here each is counted over all of them. Settled records
are measured by the undecimated transform, free of boundaries; its mean square is the mean over the phases.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.claims import alarms, claim_margins
from hydrofdi.papers.maddahi2015.grid import ABSENT, ModeGrid
from hydrofdi.report.runs import Array, baseline_changes, best_levels
from hydrofdi.report.table import Column
from hydrofdi.report.wording import signed
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names

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


def points(name: str, values: Sequence[float]) -> Column:
    """A column of percentage points."""
    return Column(name, values, text=lambda value: signed(value, 2))
