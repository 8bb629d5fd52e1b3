"""The ``fluid`` section."""

from __future__ import annotations

from typing import Annotated, Literal

from hydrofdi.settings.quantities import SI, Section


class FluidConfig(Section):
    """Fluid in the chambers."""

    bulk_modulus: Annotated[float, SI("Pa", above=0, usual=("10 MPa", "10 GPa"))] = 551e6
    """Effective bulk modulus β (EBM) [Pa]. 551 MPa = 80 kpsi is the paper's normal value."""

    vapour_pressure: Annotated[float, SI("Pa", usual=("1 Pa", "1 MPa"))] = 0.0
    """Pressure below which a chamber counts as cavitating [Pa]; on the same scale as the return pressure.
    A choice: air comes out of the oil below the tank's pressure."""

    cavitation: Literal["none", "clamped"] = "none"
    """Chamber pressure at ``vapour_pressure``. ``none``: it falls below, as if the fluid could carry tension
    (paper). ``clamped``: the pressure stays there until flow comes in again; the volume of the vapour is not
    tracked."""

    law: Literal["constant", "free_air"] = "constant"
    """Bulk modulus over pressure. ``constant``: β (paper). ``free_air``: β is that of the liquid, and free
    air softens it at low pressure. Temperature is not modelled."""

    free_air: Annotated[float, SI("1", least=0, usual=("1e-6", "0.5"))] = 0.005
    """Volume of free air over that of the liquid at atmospheric pressure, X [-]. A choice; tanks have 0.001
    to 0.05."""

    polytropic_exponent: Annotated[float, SI("1", least=1, usual=("0.1", "10"))] = 1.4
    """Polytropic exponent n of the air [-]: 1 for slow (isothermal), 1.4 for fast (adiabatic) changes."""

    atmospheric_pressure: Annotated[float, SI("Pa", above=0, usual=("10 kPa", "1 MPa"))] = 101325.0
    """Absolute pressure at which the pressures of the model are zero [Pa]."""
