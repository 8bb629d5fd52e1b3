"""The ``friction`` section: Stribeck friction with a linear zone around zero velocity."""

from __future__ import annotations

from typing import Annotated, Literal

from hydrofdi.settings.quantities import SI, Section


class FrictionConfig(Section):
    """Friction between the piston, its seals and the cylinder."""

    coulomb: Annotated[float, SI("N", least=0, usual=("0.01 N", "1 MN"))] = 200.0
    """Coulomb friction force F_c [N]. Table 1 lost all digits."""

    breakaway: Annotated[float, SI("N", least=0, usual=("0.01 N", "1 MN"))] = 250.0
    """Breakaway friction force F_brk [N]. Table 1, legible as "5"."""

    viscous: Annotated[float, SI("N*s/m", least=0, usual=("0.01 N*s/m", "10 MN*s/m"))] = 50.0
    """Viscous friction coefficient f [N·s/m]. Table 1, legible as "5"; low confidence."""

    transition: Annotated[float, SI("s/m", least=0, usual=("0.01 s/m", "100000 s/m"))] = 40.0
    """Transition coefficient c_v from breakaway to Coulomb friction [s/m]. Table 1, legible as "4"."""

    scale: Annotated[float, SI("1", least=0, usual=("0.001", "1000"))] = 1.0
    """Factor on the dry friction, F_c and F_brk (and σ_0, σ_1) together [-]. 1 is the paper; what dry
    friction does to the indicator is named there as future work."""

    law: Literal["threshold", "smooth", "lugre"] = "threshold"
    """Dry friction around zero velocity. ``threshold``: linear below v_th, with a kink there (paper, eq. 12).
    ``smooth``: the sign of the velocity becomes tanh(v_p/v_th), without a kink. ``lugre``: bristles that
    bend before they slide; in steady motion the same Stribeck force."""

    velocity_threshold: Annotated[float, SI("m/s", above=0, usual=("1 µm/s", "1 m/s"))] = 1e-3
    """Speed v_th below which friction is linear in velocity [m/s]. Table 1."""

    bristle_stiffness: Annotated[float, SI("N/m", above=0, usual=("1 N/m", "100 GN/m"))] = 5e6
    """Stiffness σ_0 of the bristles of the LuGre law [N/m]. A choice: breakaway bends them by 50 µm."""

    bristle_damping: Annotated[float, SI("N*s/m", least=0, usual=("0.01 N*s/m", "10 MN*s/m"))] = 1e3
    """Damping σ_1 of the bristles of the LuGre law [N·s/m]. A choice."""

    @property
    def dry_coulomb(self) -> float:
        """F_c as scaled [N]."""
        return self.scale * self.coulomb

    @property
    def dry_breakaway(self) -> float:
        """F_brk as scaled [N]."""
        return self.scale * self.breakaway

    @property
    def dry_bristle_stiffness(self) -> float:
        """σ_0 as scaled; none without dry friction [N/m]."""
        return self.scale * self.bristle_stiffness if self.coulomb or self.breakaway else 0.0

    @property
    def dry_bristle_damping(self) -> float:
        """σ_1 as scaled; none without dry friction [N·s/m]."""
        return self.scale * self.bristle_damping if self.coulomb or self.breakaway else 0.0
