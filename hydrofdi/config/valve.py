"""The ``valve`` section: a second-order servovalve with critically lapped, symmetric ports."""

from __future__ import annotations

from typing import Annotated

from hydrofdi.config.quantities import SI, Section


class ValveConfig(Section):
    """Servovalve."""

    flow_gain: Annotated[float, SI("m^1.5/kg^0.5", above=0)] = 0.0292
    """Flow gain K_v [m^1.5/kg^0.5], 0.6 √(2/ρ) with ρ = 847 kg/m³. Table 1, legible as ".9"."""

    area_gradient: Annotated[float, SI("m", above=0)] = 20.75e-3
    """Orifice area gradient w [m]. Low confidence: lost in Table 1, from sister works."""

    spool_gain: Annotated[float, SI("m/V", above=0)] = 22e-6
    """Spool position gain k_v [m/V]. Medium confidence; 27.9 and 40.6 µm/V are admissible."""

    natural_frequency: Annotated[float, SI("Hz", above=0)] = 175.0
    """Undamped natural frequency of the spool [Hz]; ω_v = 2π times it. Table 1, legible as "175"."""

    damping_ratio: Annotated[float, SI("1", above=0)] = 0.7
    """Damping ratio ξ of the spool [-]. Table 1, legible as ".7"."""
