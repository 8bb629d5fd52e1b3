"""Does an approximation separate external leakage from internal leakage and from a change of EBM?

After Goharrizi and Sepehri, International Journal of Fluid Power: they isolate external from internal leakage
by the level-4 approximation. Its RMS is the choice made here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hydrofdi.report.ranges import Range, range_of
from hydrofdi.report.runs.rows import LevelChanges, TableRow
from hydrofdi.report.runs.table import SensitivityTable

_LEVEL = 3
"""Position of a4; the deepest level if there are fewer."""

_D2 = 1


@dataclass(frozen=True)
class ExternalState:
    """All runs that leak out of the same chambers, with every internal leakage and EBM.

    Attributes
    ----------
    chambers : tuple of int
        1, 2, both, or none.
    rows : tuple of TableRow
    """

    chambers: tuple[int, ...]
    rows: tuple[TableRow, ...]

    @property
    def least_flow(self) -> float:
        """The smallest mean flow out of any of its chambers [m³/s]; NaN if no run succeeded."""
        return range_of(
            [row.external.flows[chamber - 1] for row in self.rows for chamber in self.chambers]
        ).low


@dataclass(frozen=True)
class ExternalStudy:
    """What external leakage does to an approximation.

    Attributes
    ----------
    level : int
        Position of the approximation.
    is_settled : bool
        Whether δ are those of the settled records; else of the records as configured, their start included.
    rows : tuple of TableRow
        Ordered by external leakage, internal leakage and EBM.
    states : tuple of ExternalState
        The one without external leakage first.
    """

    level: int
    is_settled: bool
    rows: tuple[TableRow, ...]
    states: tuple[ExternalState, ...]

    @property
    def name(self) -> str:
        """The approximation, e.g. ``a4``."""
        return f"a{self.level + 1}"

    @property
    def gain(self) -> float:
        """What the approximation makes of a constant 1 [-]."""
        return float(2.0 ** ((self.level + 1) / 2.0))

    def approximations(self, row: TableRow) -> LevelChanges:
        """The approximations of a row that are looked at."""
        return row.settled_approximations if self.is_settled else row.approximations

    def details(self, row: TableRow) -> LevelChanges:
        """The details of a row that are looked at."""
        return row.settled_details if self.is_settled else row.details

    @property
    def indicators(self) -> dict[str, Callable[[TableRow], float]]:
        """Name of a δ → δ of a row [%]; a prime marks the matched baseline."""
        level = self.level
        indicators: dict[str, Callable[[TableRow], float]] = {
            f"δ{self.name}": lambda row: self.approximations(row).fixed[level],
            f"δ′{self.name}": lambda row: self.approximations(row).matched[level],
        }
        if level >= _D2:
            indicators["δd2"] = lambda row: self.details(row).fixed[_D2]
            indicators["δ′d2"] = lambda row: self.details(row).matched[_D2]
        return indicators

    def ranges(self, state: ExternalState) -> dict[str, Range]:
        """Each δ over the runs of a state."""
        return {name: range_of([of(row) for row in state.rows]) for name, of in self.indicators.items()}

    def gaps(self, state: ExternalState) -> dict[str, float]:
        """How far apart each δ keeps a state and the runs without external leakage, in percentage points.

        Negative where they overlap: no threshold separates them.
        """
        quiet, leaky = self.ranges(self.states[0]), self.ranges(state)
        return {
            name: max(leaky[name].low - quiet[name].high, quiet[name].low - leaky[name].high)
            for name in leaky
        }

    def effect_of_bulk_modulus(self) -> Range:
        """δ of the approximation in runs that do not leak at all, against the fixed baseline [%]."""
        rows = [row for row in self.states[0].rows if row.is_sealed]
        return range_of([self.approximations(row).fixed[self.level] for row in rows])

    def effect_of_internal_leakage(self) -> Range:
        """δ of the approximation in runs that leak inside alone, against the matched baseline [%]."""
        rows = [row for row in self.states[0].rows if not row.is_sealed]
        return range_of([self.approximations(row).matched[self.level] for row in rows])

    def mean_shares(self) -> Range:
        """Share of the mean of P_1 in the square of the approximation's RMS, as configured [-]."""
        return range_of(
            [(self.gain * row.mean_pressure / row.approximations.rms[self.level]) ** 2 for row in self.rows]
        )


def study_external(table: SensitivityTable) -> ExternalStudy | None:
    """The study of an experiment that varies external leakage; None for any other."""
    if not table.varies_external:
        return None
    rows = sorted(
        table.rows,
        key=lambda row: (_chambers(row), row.external.coefficients, row.leakage_request, row.bulk_modulus),
    )
    groups = sorted({_chambers(row) for row in rows} | {()})
    states = [ExternalState(group, tuple(row for row in rows if _chambers(row) == group)) for group in groups]
    level = min(_LEVEL, table.n_level - 1)
    return ExternalStudy(level, table.has_settled, tuple(rows), tuple(states))


def _chambers(row: TableRow) -> tuple[int, ...]:
    return tuple(chamber for chamber, value in enumerate(row.external.coefficients, 1) if value > 0.0)
