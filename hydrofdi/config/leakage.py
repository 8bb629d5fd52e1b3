"""The ``leakage`` section: across the piston seal (internal) and out of the chambers (external)."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import model_validator

from hydrofdi.config.quantities import SI, Section


class LeakageConfig(Section):
    """Leakage; the internal one is given by its coefficient or by the mean flow that it shall cause."""

    internal_coefficient: Annotated[float, SI("m^3.5/kg^0.5", least=0)] | None = None
    """Coefficient K_i of the internal leakage [m^3.5/kg^0.5], i.e. m³/s per √Pa."""

    internal_flow: Annotated[float, SI("m^3/s", least=0)] | None = None
    """Mean of abs(q_il) over the record [m³/s], from which K_i is solved under the baseline's conditions."""

    external_coefficient: Annotated[float, SI("m^3/(s*Pa)", least=0)] = 0.0
    """Coefficient K_e of the external leakage of either chamber [m³/(s·Pa)]."""

    @model_validator(mode="after")
    def _one_form_of_internal_leakage(self) -> Self:
        if self.internal_coefficient is not None and self.internal_flow is not None:
            raise ValueError("give internal_coefficient or internal_flow, not both")
        return self

    @property
    def needs_calibration(self) -> bool:
        """Whether K_i has to be solved from a mean leakage flow."""
        return bool(self.internal_flow)
