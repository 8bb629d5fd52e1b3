"""A run as a row: RMS of its details, and their change against both baselines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hydrofdi.quality.doubts import Doubt, doubts_of

Levels = tuple[float, ...]
"""One number per wavelet level, d1 first; NaN if a run failed."""


@dataclass(frozen=True)
class LevelChanges:
    """One kind of coefficient of a run.

    Attributes
    ----------
    rms : tuple of float
        RMS of each level [Pa].
    fixed, matched : tuple of float
        δ [%] against the baseline's conditions, and against the sealed actuator in the run's own conditions.
    """

    rms: Levels
    fixed: Levels
    matched: Levels


@dataclass(frozen=True)
class ExternalLeakage:
    """Leakage out of chamber 1 and chamber 2: K_e [m³/(s·Pa)] and mean flows [m³/s]."""

    coefficients: tuple[float, float]
    flows: tuple[float, float]


@dataclass(frozen=True)
class TableRow:
    """One run of the table, in SI and percent.

    Attributes
    ----------
    run_id : str
        Identity of the run.
    labels : dict
        Further varied parameters → their values in SI.
    leakage_request : float
        Mean flow [m³/s] or K_i [m^3.5/kg^0.5] that was requested; 0 for a sealed actuator.
    leakage_flow : float
        Leakage level of the row [m³/s]: the mean flow that K_i was solved for, or the flow of the run.
    mean_leakage_flow : float
        Mean of abs(q_il) in the run itself [m³/s].
    leakage_coefficient, bulk_modulus : float
        K_i [m^3.5/kg^0.5] and β [Pa].
    mode_frequency, mode_damping_ratio : float
        f_h [Hz] and ζ [-].
    details, approximations : LevelChanges
        d1, d2, … and a1, a2, … of P_1, as configured.
    settled_details, settled_approximations : LevelChanges
        The same of the settled record.
    position : int
        Row in the experiment.
    external : ExternalLeakage
        Leakage out of the chambers.
    mean_pressure : float
        Mean of P_1 [Pa].
    status, message : str
        How the run ended.
    verdict : str
        Its reliability; its status if it did not succeed.
    doubt_numbers : dict
        Word of a verdict → the number behind it.
    leaks_out_more : bool
        Whether its chambers leak more than those of its healthy run.
    """

    run_id: str
    labels: dict[str, Any]
    leakage_request: float
    leakage_flow: float
    mean_leakage_flow: float
    leakage_coefficient: float
    bulk_modulus: float
    mode_frequency: float
    mode_damping_ratio: float
    details: LevelChanges
    approximations: LevelChanges
    settled_details: LevelChanges
    settled_approximations: LevelChanges
    position: int
    external: ExternalLeakage
    mean_pressure: float
    status: str
    message: str
    verdict: str
    doubt_numbers: dict[str, float]
    leaks_out_more: bool = False

    @property
    def detail_rms(self) -> Levels:
        """RMS of d1, d2, … [Pa]."""
        return self.details.rms

    @property
    def delta_fixed(self) -> Levels:
        """δ of the details against the fixed baseline [%]."""
        return self.details.fixed

    @property
    def delta_matched(self) -> Levels:
        """δ of the details against the matched baseline [%]."""
        return self.details.matched

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """What of a run that succeeded."""
        return doubts_of(self.verdict)

    @property
    def is_sealed(self) -> bool:
        """Whether the row is a control without internal leakage."""
        return self.leakage_request == 0.0


def largest_positive(levels: Sequence[float]) -> int | None:
    """Position of the largest value above zero; None if there is none."""
    best = max(
        range(len(levels)), key=lambda level: -math.inf if math.isnan(levels[level]) else levels[level]
    )
    return best if levels[best] > 0.0 else None


def level_name(level: int | None) -> str | None:
    """``d1`` for position 0, and so on."""
    return None if level is None else f"d{level + 1}"
