"""Internal leakage from the volume balance, with the spring load in place of a position sensor."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.indicators.balancing import BalanceIndicator, BalanceOptions
from hydrofdi.indicators.nominal_actuator import PlantConstant
from hydrofdi.records import RecordBatch
from hydrofdi.settings.quantities import SI


class PressureBalanceOptions(BalanceOptions):
    """Options of `PressureBalance`: as for the flow balance, with longer windows after the ringing."""

    spool: Literal["measured", "command", "square"] = "command"
    """Spool position: ``measured``; computed from the input voltage with the nominal valve (``command``); or
    a ``square`` wave that switches with the period of the drive or, if that is unknown, at the jumps of
    P_1."""

    load_stiffness: Annotated[float, SI("N/m", least=0, most=1e12), PlantConstant()] = 150e3
    """Stiffness K_ex of the spring that loads the piston [N/m], used in place of the position."""

    half_window: Annotated[int, Field(strict=True, ge=2, le=100_000)] = 36
    """Half the length of a window [samples]; windows overlap by half."""

    settling: Annotated[float, SI("s", least=0)] = 0.1
    """Time excluded after a jump of the spool [s]: the pressures ring, but the position does not."""

    error: Annotated[float, SI("m^3", above=0)] = 10e-9
    """Standard deviation of the residual of a window's balance [m³]."""

    robust: bool = True
    """Whether windows that fit poorly get less weight, such as those in which a force on the piston jumps."""


class PressureBalance(BalanceIndicator[PressureBalanceOptions]):
    """Internal leakage from the volume balance, with the spring load in place of a position sensor."""

    name = "pressure_balance"
    version = 5
    source = "flow_balance with A x_p' = A² ΔP'/K_ex: specific to hydrofdi"
    equation = (
        "∫φ q_1 = K_i ∫φ sgn(ΔP) √abs(ΔP) + (A²/K_ex) ∫φ ΔP' + (1/β) ∫φ (V + A² ΔP/K_ex) P_1'; q_1 and"
        " unknowns as in flow_balance"
    )
    caution = (
        "Only for spring loads: other slowly varying forces appear as leakage; abrupt ones are"
        " down-weighted, and friction that rises with pressure shifts the leakage by 0.1 L/min: use it with"
        " the machine's own history. β is hardly distinguishable from the spring stiffness and stays near"
        " nominal."
    )
    by_spring = True
    Options = PressureBalanceOptions

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if there is no spring, or too few windows."""
        has_spring = self.options.load_stiffness > 0.0
        return super().obstacle(records) if has_spring else "it needs a load_stiffness above 0"
