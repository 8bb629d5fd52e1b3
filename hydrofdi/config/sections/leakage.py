"""The ``leakage`` section: across the piston seal (internal) and out of the chambers (external)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from hydrofdi.settings.quantities import SI, Section

_AT_ONCE = 1e-9


class LeakageConfig(Section):
    """Leakage; the internal leakage is given by its coefficient or by the mean flow that it should cause."""

    internal_coefficient: (
        Annotated[float, SI("m^3.5/kg^0.5", least=0, usual=("1e-13 m^3.5/kg^0.5", "1e-5 m^3.5/kg^0.5"))]
        | None
    ) = None
    """Coefficient K_i of the internal leakage [m^3.5/kg^0.5], i.e. m³/s per √Pa."""

    internal_flow: Annotated[float, SI("m^3/s", least=0, usual=("0.01 mL/min", "1000 L/min"))] | None = None
    """Mean of abs(q_il) over the record [m³/s], from which K_i is solved under the baseline's conditions."""

    external_coefficient: Annotated[
        float, SI("m^3/(s*Pa)", least=0, usual=("1e-18 m^3/(s*Pa)", "1e-8 m^3/(s*Pa)"))
    ] = 0.0
    """Coefficient K_e of the external leakage of either chamber [m³/(s·Pa)]."""

    external_coefficient_1: (
        Annotated[float, SI("m^3/(s*Pa)", least=0, usual=("1e-18 m^3/(s*Pa)", "1e-8 m^3/(s*Pa)"))] | None
    ) = None
    """Coefficient of the external leakage of chamber 1 only [m³/(s·Pa)]; by default
    ``external_coefficient``."""

    external_coefficient_2: (
        Annotated[float, SI("m^3/(s*Pa)", least=0, usual=("1e-18 m^3/(s*Pa)", "1e-8 m^3/(s*Pa)"))] | None
    ) = None
    """Coefficient of the external leakage of chamber 2 only [m³/(s·Pa)]; by default
    ``external_coefficient``."""

    law: Literal["orifice", "laminar", "blended"] = "orifice"
    """Internal leakage over the pressure difference ΔP. ``orifice``: K_i √ΔP (paper, eq. 11). ``laminar``:
    proportional to ΔP, a gap that leaks as much as the orifice at ``laminar_reference``. ``blended``: the
    orifice with its infinite slope at zero smoothed over ``blending_pressure``."""

    laminar_reference: Annotated[float, SI("Pa", above=0, usual=("10 kPa", "100 MPa"))] = 10e6
    """Pressure difference at which the laminar gap leaks as much as the orifice of the same K_i [Pa].
    A choice: about the mean difference over a stroke."""

    blending_pressure: Annotated[float, SI("Pa", above=0, usual=("0.1 Pa", "1 MPa"))] = 1e3
    """Pressure difference Δp_small below which the blended law is linear [Pa]. A choice, far below any
    difference that matters."""

    onset: Literal["constant", "step", "ramp", "intermittent"] = "constant"
    """K_i over time. ``constant``: from the start (paper). ``step``: from ``onset_time`` on. ``ramp``: rising
    over ``onset_duration``. ``intermittent``: open for a share ``onset_duty`` of every ``onset_duration``."""

    onset_time: Annotated[float, SI("s", least=0, usual=("1 µs", "24 h"))] = 0.0
    """Time at which the internal leakage sets in [s]."""

    onset_duration: Annotated[float, SI("s", above=0, usual=("1 ms", "24 h"))] = 1.0
    """Rise time of a ramp, or period of an intermittent leak [s]."""

    onset_duty: Annotated[float, SI("1", least=0, most=1)] = 0.5
    """Share of the period during which an intermittent leak is open [-]."""

    @model_validator(mode="after")
    def _one_form_of_internal_leakage(self) -> Self:
        if self.internal_coefficient is not None and self.internal_flow is not None:
            raise ValueError("give internal_coefficient or internal_flow, not both")
        return self

    @property
    def chamber_1_coefficient(self) -> float:
        """K_e of chamber 1 [m³/(s·Pa)]."""
        own = self.external_coefficient_1
        return self.external_coefficient if own is None else own

    @property
    def chamber_2_coefficient(self) -> float:
        """K_e of chamber 2 [m³/(s·Pa)]."""
        own = self.external_coefficient_2
        return self.external_coefficient if own is None else own

    @property
    def rise_start(self) -> float:
        """When the leakage begins to open [s]; a step does so just before its time."""
        return self.onset_time - self.rise_duration if self.onset == "step" else self.onset_time

    @property
    def rise_duration(self) -> float:
        """How long the leakage takes to open, or the period of an intermittent one [s]."""
        return _AT_ONCE if self.onset == "step" else self.onset_duration

    @property
    def needs_calibration(self) -> bool:
        """Whether K_i has to be solved from a mean leakage flow."""
        return bool(self.internal_flow)
