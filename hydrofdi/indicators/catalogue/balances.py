"""Internal leakage and bulk modulus from the volume balance, with the position or with a spring."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.indicators.balancing import BalanceIndicator, BalanceOptions
from hydrofdi.records import RecordBatch
from hydrofdi.records.data_sheet import PlantConstant
from hydrofdi.settings.quantities import SI


class FlowBalance(BalanceIndicator[BalanceOptions]):
    """Internal leakage, bulk modulus and valve parameters from the volume balance of the chambers."""

    name = "flow_balance"
    version = 7
    source = (
        "weak form: Shinbrot, NACA TN 3288 (1954); balance: equations (5) to (8) and (11) of the paper;"
        " deviations: Tarantola, Inverse Problem Theory (2005), section 3.2"
    )
    equation = (
        "∫φ(q_1 − A x_p') = K_i ∫φ sgn(ΔP) √abs(ΔP) + (1/β) ∫φ (V + A x_p) P_1', φ = sin²; chamber 2"
        " alike; q_1 = K_v w g_e (x_v − x_0 ∓ lap_e) √drop + c (P_s + P_r − 2 P_1) for the open edge e,"
        " c ≥ 0; 1/β + air (P_a/P)^(3/4)·3/(4P) for free air; P_s falls with the flow drawn; all but K_i are"
        " constrained to nominal values by their prior deviations. Errors have the standard deviation e, or"
        " e misfit if that is larger. Stated deviations of flows count the excess 50 times, allow three times"
        " the prior deviations, 5 % of the flow of c in K_i, and 30 % of mean_leakage for its law and place."
        " mean_leakage and cross_port_leakage follow from a second solution whose c may be that of a leak."
        " For the mean_leakage of a record each tenth of the way has its own K_i, which differs by three"
        " times the common one, and covariances of residuals of windows apart count like an excess"
    )
    caution = (
        "K_i (leakage) finds a hole or a scored bore whatever the valve leaks. mean_leakage and"
        " cross_port_leakage are right for any law, but contain the clearance of the valve: a gap is found"
        " beyond its null leakage alone, and cannot be told from a valve that leaks more. Pressure noise"
        " biases β upwards."
    )
    Options = BalanceOptions


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
