"""The ``supply`` section: the pressures on the pump side of the valve."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import model_validator

from hydrofdi.config.quantities import SI, Section


class SupplyConfig(Section):
    """Constant supply and return pressures."""

    pressure: Annotated[float, SI("Pa", above=0)] = 17.2e6
    """Supply pressure P_s [Pa]. 2500 psi on the test rig."""

    return_pressure: Annotated[float, SI("Pa", least=0)] = 0.0
    """Return pressure P_r [Pa]."""

    @model_validator(mode="after")
    def _supply_exceeds_return(self) -> Self:
        if self.pressure <= self.return_pressure:
            raise ValueError("the supply pressure must be above the return pressure")
        return self
