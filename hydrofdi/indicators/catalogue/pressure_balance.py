"""Internal leakage from the balance of volume where the spring of the load stands in for the position."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.indicators.balancing import Balance, BalanceOptions
from hydrofdi.settings.quantities import SI


class PressureBalanceOptions(BalanceOptions):
    """Options of `PressureBalance`: those of the flow balance, with longer windows after the ringing."""

    spool: Literal["measured", "command", "square"] = "command"
    """Where the spool is: as measured, where the nominal valve puts it under the input voltage, or where a
    square wave puts it that turns with the period of the drive or, unknown, with the jumps of P_1."""

    half_window: Annotated[int, Field(strict=True, ge=2, le=100_000)] = 36
    """Half the length of a window [samples]; windows overlap by half."""

    settling: Annotated[float, SI("s", least=0)] = 0.1
    """Time after a jump of the spool that is left out [s]: the pressures ring, and the position does not."""

    error: Annotated[float, SI("m^3", above=0)] = 30e-9
    """Standard deviation of what the balance of a window leaves [m³]."""

    robust: bool = True
    """Whether windows that fit badly count less: those in which a force on the piston jumps."""


class PressureBalance(Balance[PressureBalanceOptions]):
    """K_i, β and valve that explain where the volume goes, by pressures alone."""

    name = "pressure_balance"
    version = 2
    summary = (
        "Internal leakage by the volume balance, without a position: the spring of the load stands in for it."
    )
    source = "flow_balance with A x_p' = A² ΔP'/K_ex: a choice of hydrofdi"
    equation = (
        "∫φ q_1 = K_i ∫φ sgn(ΔP) √abs(ΔP) + (A²/K_ex) ∫φ ΔP' + (1/β) ∫φ (V + A² ΔP/K_ex) P_1'; q_1 and"
        " unknowns as in flow_balance"
    )
    caution = (
        "For a load that is a spring: other forces that change slowly count as leakage; those that jump are"
        " weighed down. β hardly differs from the spring, so it keeps near its nominal value."
    )
    by_spring = True
    Options = PressureBalanceOptions
