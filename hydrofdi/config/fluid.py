"""The ``fluid`` section."""

from __future__ import annotations

from typing import Annotated

from hydrofdi.config.quantities import SI, Section


class FluidConfig(Section):
    """Fluid in the chambers."""

    bulk_modulus: Annotated[float, SI("Pa", above=0)] = 551e6
    """Effective bulk modulus β (EBM) [Pa]. 551 MPa = 80 kpsi is the paper's normal value."""
