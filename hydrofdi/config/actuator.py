"""The ``actuator`` section: a double-rod cylinder and its load."""

from __future__ import annotations

from typing import Annotated

from hydrofdi.config.quantities import SI, Section


class ActuatorConfig(Section):
    """Double-rod cylinder with equal piston areas that moves a mass against a spring."""

    mass: Annotated[float, SI("kg", above=0)] = 12.3
    """Mass m of piston and load [kg]. Table 1 of the paper, legible as "1.3"."""

    piston_area: Annotated[float, SI("m^2", above=0)] = 633e-6
    """Annular area A of either piston side [m²]. Bore 38.1 mm and rod 25.4 mm of the test rig."""

    chamber_volume: Annotated[float, SI("m^3", above=0)] = 280e-6
    """Fluid volume V of each chamber with the piston centred [m³]. Low confidence: fixed only by the
    sentences of the paper; 160 to 470 cm³ are admissible."""

    load_stiffness: Annotated[float, SI("N/m", least=0)] = 150e3
    """Stiffness K_ex of the environment spring [N/m]. Table 1, legible as "15"."""
