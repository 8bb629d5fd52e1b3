"""The ``friction`` section: Stribeck friction with a linear zone around zero velocity."""

from __future__ import annotations

from typing import Annotated, Literal

from hydrofdi.config.quantities import SI, Section


class FrictionConfig(Section):
    """Friction between the piston, its seals and the cylinder."""

    coulomb: Annotated[float, SI("N", least=0)] = 200.0
    """Coulomb friction force F_c [N]. Table 1 lost all digits."""

    breakaway: Annotated[float, SI("N", least=0)] = 250.0
    """Breakaway friction force F_brk [N]. Table 1, legible as "5"."""

    viscous: Annotated[float, SI("N*s/m", least=0)] = 50.0
    """Viscous friction coefficient f [N·s/m]. Table 1, legible as "5"; low confidence."""

    transition: Annotated[float, SI("s/m", least=0)] = 40.0
    """Transition coefficient c_v from breakaway to Coulomb friction [s/m]. Table 1, legible as "4"."""

    scale: Annotated[float, SI("1", least=0)] = 1.0
    """Factor on the dry friction, F_c and F_brk together [-]. 1 is the paper; what dry friction does to the
    indicator is named there as future work."""

    law: Literal["threshold", "smooth"] = "threshold"
    """Dry friction around zero velocity. ``threshold``: linear below v_th, with a kink there (paper, eq. 12).
    ``smooth``: the sign of the velocity becomes tanh(v_p/v_th), without a kink."""

    velocity_threshold: Annotated[float, SI("m/s", above=0)] = 1e-3
    """Speed v_th below which friction is linear in velocity [m/s]. Table 1."""

    @property
    def dry_coulomb(self) -> float:
        """F_c as scaled [N]."""
        return self.scale * self.coulomb

    @property
    def dry_breakaway(self) -> float:
        """F_brk as scaled [N]."""
        return self.scale * self.breakaway
