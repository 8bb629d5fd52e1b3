"""The ``actuator`` section: a double-rod cylinder and its load."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from hydrofdi.settings.quantities import SI, Section


class ActuatorConfig(Section):
    """Double-rod cylinder with equal piston areas that moves a mass against a spring."""

    mass: Annotated[float, SI("kg", above=0, usual=("10 g", "100000 kg"))] = 12.3
    """Mass m of piston and load [kg]. Table 1 of the paper, legible as "1.3"."""

    piston_area: Annotated[float, SI("m^2", above=0, usual=("1 mm^2", "1 m^2"))] = 633e-6
    """Annular area A of either piston side [m²]. Bore 38.1 mm and rod 25.4 mm of the test rig."""

    chamber_volume: Annotated[float, SI("m^3", above=0, usual=("0.1 cm^3", "1 m^3"))] = 280e-6
    """Fluid volume V of each chamber with the piston centred [m³]. Low confidence: constrained only by the
    paper's statements; 160 to 470 cm³ are admissible."""

    load_stiffness: Annotated[float, SI("N/m", least=0, usual=("1 N/m", "10 GN/m"))] = 150e3
    """Stiffness K_ex of the environment spring [N/m]. Table 1, legible as "15"."""

    end_stops: Literal["none", "elastic"] = "none"
    """End of the stroke. ``none``: no stops (paper); a run whose piston leaves the cylinder fails.
    ``elastic``: a spring of ``end_stop_stiffness`` from ``end_stop_position`` on."""

    end_stop_position: Annotated[float, SI("m", above=0, usual=("1 mm", "10 m"))] = 0.3
    """Distance of either end stop from the centre [m]. A choice, below the V/A at which a chamber
    vanishes."""

    end_stop_stiffness: Annotated[float, SI("N/m", above=0, usual=("1 kN/m", "100 GN/m"))] = 20e6
    """Stiffness of an end stop [N/m]. A choice, well above that of the fluid."""

    @model_validator(mode="after")
    def _end_stops_lie_within_the_cylinder(self) -> Self:
        stroke = self.chamber_volume / self.piston_area
        if self.end_stops == "elastic" and self.end_stop_position >= stroke:
            raise ValueError(
                f"end_stop_position = {self.end_stop_position:g} m must be below V/A = {stroke:.4g} m,"
                " where a chamber vanishes"
            )
        return self
