"""The ``fluid`` section."""

from __future__ import annotations

from typing import Annotated

from hydrofdi.config.quantities import SI, Section


class FluidConfig(Section):
    """Fluid in the chambers."""

    bulk_modulus: Annotated[float, SI("Pa", above=0)] = 551e6
    """Effective bulk modulus β (EBM) [Pa]. 551 MPa = 80 kpsi is the paper's normal value."""

    vapour_pressure: Annotated[float, SI("Pa")] = 0.0
    """Pressure below which a chamber counts as cavitating [Pa]; on the same scale as the return pressure.
    A choice: the equations do not know it, but air comes out of the oil below the tank's pressure."""
