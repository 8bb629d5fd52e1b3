"""The ``friction`` section: Stribeck friction with a linear zone around zero velocity."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.settings.quantities import SI, Section

if TYPE_CHECKING:
    LawName = str
else:
    LawName = Literal[tuple(FRICTION_LAWS)]


class AppliedFriction(NamedTuple):
    """Parameters of friction with the scale of the dry part applied, in SI."""

    coulomb: float
    breakaway: float
    viscous: float
    transition: float
    velocity_threshold: float
    bristle_stiffness: float
    bristle_damping: float


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
    """Factor on the dry friction, F_c and F_brk (and σ_0, σ_1) together [-]. 1 is the paper, which leaves the
    effect of dry friction on the indicator to future work."""

    law: LawName = "threshold"
    """Dry friction around zero velocity. ``threshold``: linear below v_th, with a kink there (paper, eq. 12).
    ``smooth``: the sign of the velocity becomes tanh(v_p/v_th), without a kink. ``lugre``: bristles that
    bend before they slide; in steady motion the same Stribeck force."""

    velocity_threshold: Annotated[float, SI("m/s", above=0, usual=("1 µm/s", "1 m/s"))] = 1e-3
    """Speed v_th below which friction is linear in velocity [m/s]. Table 1."""

    bristle_stiffness: Annotated[float, SI("N/m", above=0, usual=("1 N/m", "100 GN/m"))] = 5e6
    """Stiffness σ_0 of the bristles of the LuGre law [N/m]. A choice: breakaway bends them by 50 µm."""

    bristle_damping: Annotated[float, SI("N*s/m", least=0, usual=("0.01 N*s/m", "10 MN*s/m"))] = 1e3
    """Damping σ_1 of the bristles of the LuGre law [N·s/m]. A choice."""

    @cached_property
    def applied(self) -> AppliedFriction:
        """What acts: dry friction scaled; no bristles where there is none."""
        bristles = self.scale if self.coulomb or self.breakaway else 0.0
        return AppliedFriction(
            self.scale * self.coulomb, self.scale * self.breakaway, self.viscous, self.transition,
            self.velocity_threshold, bristles * self.bristle_stiffness, bristles * self.bristle_damping,
        )  # fmt: skip
