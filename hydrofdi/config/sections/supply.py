"""The ``supply`` section: the pressures on the pump side of the valve."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from hydrofdi.settings import usual
from hydrofdi.settings.quantities import SI, Section


class SupplyConfig(Section):
    """Supply and return pressures."""

    pressure: Annotated[float, SI("Pa", above=0, usual=usual.SUPPLY_PRESSURE)] = 17.2e6
    """Supply pressure P_s [Pa]. 2500 psi on the test rig."""

    return_pressure: Annotated[float, SI("Pa", least=0, usual=usual.RETURN_PRESSURE)] = 0.0
    """Return pressure P_r [Pa]."""

    droop: Literal["none", "first_order"] = "none"
    """Supply pressure under flow. ``none``: constant (paper). ``first_order``: it falls
    by ``droop_resistance`` times the flow, with a lag of ``droop_time_constant``."""

    droop_resistance: Annotated[float, SI("Pa*s/m^3", least=0, usual=("1e7 Pa*s/m^3", "1e13 Pa*s/m^3"))] = (
        2e10
    )
    """Drop of the supply pressure per unit of flow, R_s [Pa·s/m³]. A choice: 2 MPa at 6 L/min."""

    droop_time_constant: Annotated[float, SI("s", above=0, usual=("0.1 ms", "100 s"))] = 0.05
    """Time constant τ_s with which the supply pressure responds to flow [s]. A choice."""

    @model_validator(mode="after")
    def _supply_exceeds_return(self) -> Self:
        if self.pressure <= self.return_pressure:
            raise ValueError("the supply pressure must be above the return pressure")
        return self
