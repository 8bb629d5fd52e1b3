"""The sections of the machine: actuator, fluid, friction, leakage, load, supply, and the servovalve."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from hydrofdi.physics import Quantity
from hydrofdi.physics.cylinder import axial_weight, internal_leakage_flow
from hydrofdi.physics.fluid import stiffening_bulk_modulus
from hydrofdi.physics.friction import FRICTION_LAWS
from hydrofdi.settings import quantities as usual
from hydrofdi.settings.messages import shown_quantity
from hydrofdi.settings.quantities import SI, Section

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    LawName = str
else:
    LawName = Literal[tuple(FRICTION_LAWS)]


CONDUCTANCE = SI("m^3/(s*Pa)", least=0, usual=("1e-18 m^3/(s*Pa)", "1e-8 m^3/(s*Pa)"))
Conductance = Annotated[float, CONDUCTANCE]
"""Flow per pressure of clearances and external leakage [m³/(s·Pa)]."""


class ActuatorConfig(Section):
    """Cylinder with one rod or two that moves a mass against a spring; by default both areas are equal."""

    mass: Annotated[float, SI("kg", above=0, usual=("10 g", "100000 kg"), symbols="m M")] = 12.3
    """Mass m of piston and load [kg]. Table 1 of the paper, legible as "1.3"."""

    piston_area: Annotated[float, SI("m^2", above=0, usual=("1 mm^2", "1 m^2"), symbols="A A_1 A1")] = 633e-6
    """Piston area A_1 of chamber 1 [m²], which grows if the rod extends: with a single rod the area of the
    bore. Bore 38.1 mm and rods of 25.4 mm on both sides of the test rig."""

    piston_area_2: (
        Annotated[float, SI("m^2", above=0, usual=("1 mm^2", "1 m^2"), symbols="A_2 A2")] | None
    ) = None
    """Piston area A_2 of chamber 2 [m²]: with a single rod the bore less the rod. By default A_1, as with two
    equal rods (paper)."""

    chamber_volume: Annotated[float, SI("m^3", above=0, usual=("0.1 cm^3", "1 m^3"), symbols="V V_1 V1")] = (
        280e-6
    )
    """Fluid volume V_1 of chamber 1 with the piston centred [m³]. Low confidence: constrained only by the
    paper's statements; 160 to 470 cm³ are admissible."""

    chamber_volume_2: (
        Annotated[float, SI("m^3", above=0, usual=("0.1 cm^3", "1 m^3"), symbols="V_2 V2")] | None
    ) = None
    """Fluid volume V_2 of chamber 2 with the piston centred [m³]; by default V_1 A_2/A_1."""

    stroke: Annotated[float, SI("m", above=0, usual=("1 mm", "20 m"))] | None = None
    """Stroke from end to end [m], half of it on each side of the centre; a run whose piston leaves it fails.
    By default the piston may move until a chamber vanishes (paper)."""

    inclination: Annotated[float, SI("rad", least=-0.5 * math.pi, most=0.5 * math.pi)] = 0.0
    """Angle of the axis above the horizontal [rad]; write ``90 deg`` if the rod extends upwards, ``-90 deg``
    if it points down. The weight of the mass acts along the axis. Horizontal in the paper."""

    load_stiffness: Annotated[float, SI("N/m", least=0, usual=("1 N/m", "10 GN/m"), symbols="K_ex")] = 150e3
    """Stiffness K_ex of the environment spring [N/m]. Table 1, legible as "15"."""

    end_stops: Literal["none", "elastic"] = "none"
    """End of the stroke. ``none``: no stops (paper); a run whose piston leaves the cylinder fails.
    ``elastic``: a spring of ``end_stop_stiffness`` from ``end_stop_position`` on, or from the ends of a
    stated ``stroke``."""

    end_stop_position: Annotated[float, SI("m", above=0, usual=("1 mm", "10 m"))] = 0.3
    """Distance of either end stop from the centre without a ``stroke`` [m]. A choice, below the V/A at which
    a chamber vanishes."""

    end_stop_stiffness: Annotated[float, SI("N/m", above=0, usual=("1 kN/m", "100 GN/m"))] = 20e6
    """Stiffness of an end stop [N/m]. A choice, well above that of the fluid."""

    hose_volume: Annotated[float, SI("m^3", least=0, usual=("0.01 cm^3", "0.1 m^3"))] = 0.0
    """Volume of the hose between valve and each chamber [m³]; none with 0 (paper). The other settings of the
    hoses act only with a volume."""

    hose_modulus: Annotated[float, SI("Pa", above=0, usual=("1 MPa", "10 GPa"))] = 400e6
    """Effective bulk modulus of oil and wall of a hose [Pa]. A choice."""

    hose_resistance: Annotated[float, SI("Pa*s/m^3", least=0, usual=("1e6 Pa*s/m^3", "1e13 Pa*s/m^3"))] = 2e9
    """Pressure drop per flow through a hose, R_h [Pa·s/m³]. A choice."""

    hose_inertance: Annotated[float, SI("kg/m^4", above=0, usual=("1000 kg/m^4", "1e10 kg/m^4"))] = 1e7
    """Inertance I_h of the oil in a hose [kg/m⁴]: density times length over cross-section. A choice: 1 m of
    10 mm."""

    foundation_stiffness: Annotated[float, SI("N/m", above=0, usual=("1 kN/m", "1000 GN/m"))] | None = None
    """Stiffness of the support of the cylinder [N/m]; by default rigid (paper). Positions are measured to the
    ground, so the chambers differ from what they show. The cylinder has no mass."""

    foundation_damping: Annotated[float, SI("N*s/m", above=0, usual=("1 N*s/m", "1 GN*s/m"))] = 20e3
    """Damping of this support [N·s/m]. A choice."""

    @property
    def support_stiffness(self) -> float:
        """Stiffness of the support [N/m], 0 if it is rigid and does not move."""
        return self.foundation_stiffness or 0.0

    @property
    def area_2(self) -> float:
        """A_2 [m²]."""
        return self.piston_area if self.piston_area_2 is None else self.piston_area_2

    @property
    def volume_2(self) -> float:
        """V_2 with the piston centred [m³]."""
        own = self.chamber_volume_2
        return self.chamber_volume * (self.area_2 / self.piston_area) if own is None else own

    @property
    def areas(self) -> tuple[float, float]:
        """A_1 and A_2 [m²]."""
        return self.piston_area, self.area_2

    def volumes_at(self, position: float) -> tuple[float, float]:
        """Volumes of both chambers at a position from the centre [m³]."""
        return self.chamber_volume + self.piston_area * position, self.volume_2 - self.area_2 * position

    @property
    def has_unequal_chambers(self) -> bool:
        """Whether areas or volumes of the chambers differ."""
        return self.area_2 != self.piston_area or self.volume_2 != self.chamber_volume

    @property
    def weight(self) -> float:
        """Weight of the mass along the axis, against extension [N]."""
        return axial_weight(self.mass, self.inclination)

    @property
    def vanishing(self) -> tuple[float, float]:
        """Positions at which chamber 1 and chamber 2 vanish, −V_1/A_1 and V_2/A_2 [m]."""
        return -self.chamber_volume / self.piston_area, self.volume_2 / self.area_2

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the stroke, or where a chamber vanishes if none is stated [m]."""
        return self.vanishing if self.stroke is None else (-0.5 * self.stroke, 0.5 * self.stroke)

    @property
    def stop_position(self) -> float:
        """Distance of either end stop from the centre [m]."""
        return self.end_stop_position if self.stroke is None else 0.5 * self.stroke

    @property
    def reach(self) -> tuple[float, ...]:
        """Positions whose modes bound those of the actuator: ends of a stated stroke, else the centre [m]."""
        return (0.0,) if self.stroke is None else self.ends

    @model_validator(mode="after")
    def _chambers_have_a_volume(self) -> Self:
        low, high = self.vanishing
        for name, distance in (
            ("half of stroke", 0.5 * (self.stroke or 0.0)),
            ("end_stop_position", self.stop_position if self.end_stops == "elastic" else 0.0),
        ):
            if distance >= min(-low, high):
                raise ValueError(
                    f"{name} = {distance:g} m must be below V/A = {min(-low, high):.4g} m, where chamber"
                    f" {1 if -low <= high else 2} vanishes"
                )
        return self


class FluidConfig(Section):
    """Fluid in the chambers."""

    bulk_modulus: Annotated[
        float, SI("Pa", above=0, usual=("200 MPa", "4 GPa"), symbols="EBM ebm beta beta_e β")
    ] = 551e6
    """Effective bulk modulus β (EBM) [Pa]. 551 MPa = 80 kpsi is the paper's normal value."""

    bulk_modulus_pressure_slope: Annotated[float, SI("1", least=0, most=100, usual=("1", "20"))] = 0.0
    """Rise of β per pressure, m [-]; ``bulk_modulus`` is then that at the pressure zero. The tangent modulus
    of a mineral oil without air rises by 10 to 12 (Hayward, 1970). None in the paper."""

    vapour_pressure: Annotated[float, SI("Pa", usual=("1 Pa", "1 MPa"))] = 0.0
    """Pressure below which a chamber counts as cavitating [Pa]; on the same scale as the return pressure. It
    falls below, as if the fluid could carry tension (paper). A choice: air comes out of the oil below the
    tank's pressure."""

    law: Literal["constant", "free_air"] = "constant"
    """Bulk modulus over pressure. ``constant``: β (paper). ``free_air``: β is that of the liquid, and free
    air softens it at low pressure."""

    free_air: Annotated[float, SI("1", least=0, usual=("1e-6", "0.5"))] = 0.005
    """Volume of free air over that of the liquid at atmospheric pressure, X [-]. A choice; tanks have 0.001
    to 0.05."""

    polytropic_exponent: Annotated[float, SI("1", least=1, usual=("0.1", "10"))] = 1.4
    """Polytropic exponent n of the air [-]: 1 for slow (isothermal), 1.4 for fast (adiabatic) changes."""

    atmospheric_pressure: Annotated[float, SI("Pa", above=0, usual=("10 kPa", "1 MPa"))] = 101325.0
    """Absolute pressure at which the pressures of the model are zero [Pa]."""

    temperature: Annotated[float, SI("K", above=0, usual=("230 K", "400 K"))] | None = None
    """Temperature of the oil for which the other parameters are given [K], such as ``45 °C``; it has no
    effect on the motion. If stated, records have the channel ``oil_temperature``: this temperature with rise
    and drift, as ``temperature_sensor`` shows it."""

    temperature_rise: Annotated[float, SI("K", usual=("0.01 K", "100 K"))] = 0.0
    """Temperature of the oil at the start of the record above that for which the other parameters are given
    [K]. It changes β, viscous friction, and all laminar leakage: clearances of the valve, external leakage,
    and internal leakage of the law ``laminar``."""

    temperature_drift: Annotated[float, SI("K/s", usual=("1e-6 K/s", "10 K/s"))] = 0.0
    """Rate at which it rises over the record [K/s]."""

    bulk_modulus_slope: Annotated[float, SI("1/K", usual=("1e-5 1/K", "0.1 1/K"))] = -0.005
    """Relative change of β per temperature [1/K]. A choice of the order of mineral oil."""

    viscosity_slope: Annotated[float, SI("1/K", usual=("1e-4 1/K", "0.2 1/K"))] = -0.03
    """Relative change of the viscosity per temperature [1/K]. A choice of the order of mineral oil near its
    working temperature."""

    @property
    def is_constant(self) -> bool:
        """Whether β does not depend on pressure."""
        return self.law == "constant" and self.bulk_modulus_pressure_slope == 0.0

    def modulus_at(self, pressure: float) -> float:
        """β without air at a pressure [Pa]."""
        return float(stiffening_bulk_modulus(pressure, self.bulk_modulus, self.bulk_modulus_pressure_slope))

    def temperature_at(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Temperature of the oil at times since the start of the record [K]; NaN if it is not stated."""
        start = math.nan if self.temperature is None else self.temperature + self.temperature_rise
        return start + self.temperature_drift * time


class FrictionConfig(Section):
    """Friction between the piston, its seals and the cylinder."""

    coulomb: Annotated[float, SI("N", least=0, usual=("0.01 N", "1 MN"), symbols="F_c")] = 200.0
    """Coulomb friction force F_c [N]. Table 1 lost all digits."""

    breakaway: Annotated[float, SI("N", least=0, usual=("0.01 N", "1 MN"), symbols="F_brk")] = 250.0
    """Breakaway friction force F_brk [N]. Table 1, legible as "5"."""

    viscous: Annotated[float, SI("N*s/m", least=0, usual=("0.01 N*s/m", "10 MN*s/m"), symbols="f")] = 50.0
    """Viscous friction coefficient f [N·s/m]. Table 1, legible as "5"; low confidence."""

    transition: Annotated[float, SI("s/m", least=0, usual=("0.01 s/m", "100000 s/m"), symbols="c_v")] = 40.0
    """Transition coefficient c_v from breakaway to Coulomb friction [s/m]. Table 1, legible as "4"."""

    scale: Annotated[float, SI("1", least=0, usual=("0.001", "1000"))] = 1.0
    """Factor on the dry friction, F_c and F_brk (and σ_0, σ_1) together [-]. 1 is the paper, which leaves the
    effect of dry friction on the indicator to future work."""

    law: LawName = "threshold"
    """Dry friction around zero velocity. ``threshold``: linear below v_th, with a kink there (paper, eq. 12).
    ``smooth``: the sign of the velocity becomes tanh(v_p/v_th), without a kink. ``lugre``: bristles that
    bend before they slide; in steady motion the same Stribeck force."""

    velocity_threshold: Annotated[float, SI("m/s", above=0, usual=("1 µm/s", "1 m/s"), symbols="v_th")] = 1e-3
    """Speed v_th below which friction is linear in velocity [m/s]. Table 1."""

    bristle_stiffness: Annotated[float, SI("N/m", above=0, usual=("1 N/m", "100 GN/m"))] = 5e6
    """Stiffness σ_0 of the bristles of the LuGre law [N/m]. A choice: breakaway bends them by 50 µm."""

    bristle_damping: Annotated[float, SI("N*s/m", least=0, usual=("0.01 N*s/m", "10 MN*s/m"))] = 1e3
    """Damping σ_1 of the bristles of the LuGre law [N·s/m]. A choice."""

    pressure_slope: Annotated[float, SI("1/Pa", least=0, usual=("1e-10 1/Pa", "1e-5 1/Pa"))] = 0.0
    """Relative rise of the dry friction per pressure difference of the chambers, which presses on the seals
    [1/Pa]; ``5 %/MPa`` makes 40 % at 8 MPa. None in the paper."""

    position_share: Annotated[float, SI("1", least=0, most=0.95, usual=("0.001", "0.9"))] = 0.0
    """Relative amplitude of the dry friction along the stroke [-]: a sine of ``position_period``."""

    position_period: Annotated[float, SI("m", above=0, usual=("1 mm", "10 m"))] = 0.05
    """Length of a period of the dry friction along the stroke [m]. A choice."""

    def largest(self, pressure: float) -> FrictionConfig:
        """What acts at most up to a pressure difference [Pa]."""
        factor = (1.0 + self.pressure_slope * pressure) * (1.0 + self.position_share)
        return self.applied.model_copy(
            update={"coulomb": factor * self.applied.coulomb, "breakaway": factor * self.applied.breakaway}
        )

    @cached_property
    def applied(self) -> FrictionConfig:
        """What acts: dry friction scaled; no bristles where there is none."""
        bristles = self.scale if self.coulomb or self.breakaway else 0.0
        factors = {
            "coulomb": self.scale, "breakaway": self.scale,
            "bristle_stiffness": bristles, "bristle_damping": bristles,
        }  # fmt: skip
        return self.model_copy(update={name: by * self.__dict__[name] for name, by in factors.items()})


_AT_ONCE = 1e-9


REFERENCE_DROP = 8e6
"""Pressure difference at which a leak is also stated, by default by indicators as well [Pa]."""


def flow_at_reference(coefficient: Quantity) -> Quantity:
    """Flow of a K_i [m^3.5/kg^0.5] at `REFERENCE_DROP` [m³/s]."""
    return internal_leakage_flow(REFERENCE_DROP, coefficient)


class LeakageConfig(Section):
    """Leakage; the internal leakage is given by its coefficient or by the mean flow that it should cause."""

    internal_coefficient: (
        Annotated[
            float,
            SI("m^3.5/kg^0.5", least=0, usual=("1e-13 m^3.5/kg^0.5", "1e-5 m^3.5/kg^0.5"), symbols="K_i Ki"),
        ]
        | None
    ) = None
    """Coefficient K_i of the internal leakage [m³/s/√Pa], in base units m^3.5/kg^0.5."""

    internal_flow: (
        Annotated[float, SI("m^3/s", least=0, usual=("0.01 mL/min", "1000 L/min"), symbols="q_il q_i")] | None
    ) = None
    """Mean of abs(q_il) over the record [m³/s], from which K_i is solved under the baseline's conditions."""

    external_coefficient: Annotated[float, replace(CONDUCTANCE, symbols="K_e Ke")] = 0.0
    """Coefficient K_e of the external leakage of either chamber [m³/(s·Pa)]."""

    external_coefficient_1: Conductance | None = None
    """Coefficient of the external leakage of chamber 1 only [m³/(s·Pa)]; by default
    ``external_coefficient``."""

    external_coefficient_2: Conductance | None = None
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

    drag: Annotated[float, SI("Pa*s/m", least=0, usual=("1 kPa*s/m", "1 GPa*s/m"))] = 0.0
    """Pressure difference that a moving piston adds per speed by dragging oil through the gap [Pa·s/m]:
    6 µL/h² of a laminar gap of length L and height h, 1.4 MPa·s/m with 20 mm, 50 µm and 30 mPa·s. None in the
    paper."""

    scored_centre: Annotated[float, SI("m", usual=("0.1 mm", "10 m"))] = 0.0
    """Piston position in the middle of a scored part of the bore [m]."""

    scored_width: Annotated[float, SI("m", above=0, usual=("1 mm", "10 m"))] | None = None
    """Length of the scored part, over which alone the internal leak is open [m]; its ends are smooth. By
    default the leak is open over the whole stroke (paper)."""

    onset: Literal["constant", "step", "ramp"] = "constant"
    """K_i over time. ``constant``: from the start (paper). ``step``: from ``onset_time`` on. ``ramp``: rising
    over ``onset_duration``."""

    onset_time: Annotated[float, SI("s", least=0, usual=("1 µs", "24 h"))] = 0.0
    """Time at which the internal leakage sets in [s]."""

    onset_duration: Annotated[float, SI("s", above=0, usual=("1 ms", "24 h"))] = 1.0
    """Rise time of a ramp [s]."""

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
    def leaking_width(self) -> float:
        """Length of the part of the stroke over which the internal leak is open [m]."""
        return math.inf if self.scored_width is None else self.scored_width

    @property
    def rise_start(self) -> float:
        """When the leakage begins to open [s]; a step does so just before its time."""
        return self.onset_time - self.rise_duration if self.onset == "step" else self.onset_time

    @property
    def rise_duration(self) -> float:
        """How long the leakage takes to open [s]."""
        return _AT_ONCE if self.onset == "step" else self.onset_duration


class LoadConfig(Section):
    """Force against positive motion of the piston."""

    constant_force: Annotated[float, SI("N", usual=("0.01 N", "10 MN"))] = 0.0
    """Constant force [N]. None in the paper."""

    random_force: Annotated[float, SI("N", least=0, usual=("0.01 N", "10 MN"))] = 0.0
    """Largest magnitude of an additional pseudo-random force [N]: seeded levels, each held for a period."""

    random_period: Annotated[float, SI("s", above=0, usual=("1 ms", "1 h"))] = 0.5
    """Time that each level of the pseudo-random force is held [s]. A choice."""

    random_change: Annotated[float, SI("s", least=0, usual=("1 ms", "1 h"))] = 0.0
    """Beginning of that time in which the force changes evenly from the level before [s]; 0 is a jump."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of the pseudo-random force."""


class SupplyConfig(Section):
    """Supply and return pressures."""

    pressure: Annotated[float, SI("Pa", above=0, usual=usual.SUPPLY_PRESSURE, symbols="P_s Ps p_s")] = 17.2e6
    """Supply pressure P_s [Pa]. 2500 psi on the test rig."""

    return_pressure: Annotated[
        float, SI("Pa", least=0, usual=usual.RETURN_PRESSURE, symbols="P_r Pr p_r")
    ] = 0.0
    """Return pressure P_r [Pa]."""

    droop: Literal["none", "first_order"] = "none"
    """Supply pressure under flow. ``none``: constant (paper). ``first_order``: it falls
    by ``droop_resistance`` times the flow, with a lag of ``droop_time_constant``."""

    droop_resistance: Annotated[float, SI("Pa*s/m^3", least=0, usual=("1e7 Pa*s/m^3", "1e13 Pa*s/m^3"))] = (
        2e10
    )
    """Drop of the supply pressure per unit of flow, R_s [Pa·s/m³]. A choice: 2 MPa at 6 L/min."""

    droop_time_constant: Annotated[float, SI("s", above=0, usual=("0.1 ms", "100 s"))] = 0.05
    """Time constant τ_s with which the supply pressure responds to flow [s]. A choice."""

    ripple: Annotated[float, SI("1", least=0, most=1, usual=("1e-5", "0.2"))] = 0.0
    """Amplitude of the pump's ripple at the valve over ``pressure`` [-]: a sine of ``ripple_frequency``."""

    ripple_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "10 kHz"))] = 225.0
    """Frequency of the ripple [Hz]. A choice: nine pistons at 1500 rpm."""

    return_resistance: Annotated[float, SI("Pa*s/m^3", least=0, usual=("1e6 Pa*s/m^3", "1e12 Pa*s/m^3"))] = (
        0.0
    )
    """Rise of the return pressure per unit of flow to the tank [Pa·s/m³]."""

    return_time_constant: Annotated[float, SI("s", above=0, usual=("0.1 ms", "100 s"))] = 0.01
    """Time constant with which the return pressure responds to flow [s]. A choice."""

    @property
    def ripple_amplitude(self) -> float:
        """Amplitude of the ripple [Pa]."""
        return self.ripple * self.pressure

    @property
    def used_time_constant(self) -> float:
        """τ_s, infinite if the supply pressure does not respond to flow [s]."""
        return self.droop_time_constant if self.droop == "first_order" else math.inf

    @model_validator(mode="after")
    def _supply_exceeds_return(self) -> Self:
        if self.pressure <= self.return_pressure:
            raise ValueError("the supply pressure must be above the return pressure")
        return self


class EdgeConfig(Section):
    """Metering edge of the valve; by default like the others."""

    lap: Annotated[float, SI("m", usual=("10 nm", "1 mm"))] = 0.0
    """Additional lap of this edge beyond ``valve.lap`` [m]; negative if it opens earlier."""

    lap_leakage: Conductance = 0.0
    """Additional conductance of its clearance beyond ``valve.lap_leakage`` [m³/(s·Pa)]."""

    flow_gain_ratio: Annotated[float, SI("1", above=0, usual=("0.1", "10"))] = 1.0
    """Its flow gain over ``valve.flow_gain`` [-]."""


class Edge(NamedTuple):
    """What one edge has in all: x_0 [m], c_lap [m³/(s·Pa)] and K_v [m^1.5/kg^0.5]."""

    lap: float
    lap_leakage: float
    flow_gain: float


class Edges(NamedTuple):
    """The edges between supply, return and the chambers."""

    supply_1: Edge
    return_1: Edge
    supply_2: Edge
    return_2: Edge

    @property
    def clearances(self) -> tuple[float, float]:
        """Conductance of the clearances of each chamber [m³/(s·Pa)]."""
        return (
            self.supply_1.lap_leakage + self.return_1.lap_leakage,
            self.supply_2.lap_leakage + self.return_2.lap_leakage,
        )


class ValveConfig(Section):
    """Servovalve."""

    flow_gain: Annotated[
        float, SI("m^1.5/kg^0.5", above=0, usual=("0.001 m^1.5/kg^0.5", "0.5 m^1.5/kg^0.5"), symbols="K_v")
    ] = 0.0292
    """Flow gain K_v [m^1.5/kg^0.5], 0.6 √(2/ρ) with ρ = 847 kg/m³. Table 1, legible as ".9"."""

    area_gradient: Annotated[float, SI("m", above=0, usual=("0.1 mm", "1 m"), symbols="w")] = 20.75e-3
    """Orifice area gradient w [m]. Low confidence: lost in Table 1, from sister works."""

    spool_gain: Annotated[float, SI("m/V", above=0, usual=("10 nm/V", "10 mm/V"), symbols="k_v")] = 22e-6
    """Spool position gain k_v [m/V]. Medium confidence; 27.9 and 40.6 µm/V are admissible."""

    natural_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "10 kHz"), symbols="f_v")] = 175.0
    """Undamped natural frequency of the spool [Hz]; ω_v = 2π times it. Table 1, legible as "175"."""

    damping_ratio: Annotated[float, SI("1", above=0, usual=("0.05", "5"), symbols="xi ξ")] = 0.7
    """Damping ratio ξ of the spool [-]. Table 1, legible as ".7"."""

    largest_opening: Annotated[float, SI("m", above=0, usual=usual.SPOOL_POSITION)] | None = None
    """Spool position at which the valve saturates [m]; by default unlimited (paper)."""

    largest_speed: Annotated[float, SI("m/s", above=0, usual=("0.1 mm/s", "100 m/s"))] | None = None
    """Slew limit of the spool [m/s]; by default unlimited (paper)."""

    hysteresis: Annotated[float, SI("V", least=0, usual=("0.1 mV", "10 V"))] = 0.0
    """Width of the hysteresis between voltage and spool [V]: how far the voltage must reverse before the
    spool does. Independent of rate (backlash). None in the paper."""

    lap: Annotated[float, SI("m", usual=("10 nm", "1 mm"))] = 0.0
    """Distance x_0 that the spool must move before an edge opens [m]: overlap (dead band) where positive,
    underlap (all edges open at the centre) where negative, critical lap where zero (paper)."""

    lap_leakage: Conductance = 0.0
    """Conductance of the clearance over each of the four edges [m³/(s·Pa)]. None in the paper."""

    edge_rounding: Annotated[float, SI("m", least=0, usual=("10 nm", "1 mm"))] = 0.0
    """Radius of the four edges [m]: an edge opens and shuts over about that travel instead of at a point, and
    at its lap it is open by half of it. Sharp in the paper."""

    gain_slope: Annotated[float, SI("1/m", usual=("0.1 1/m", "100000 1/m"))] = 0.0
    """Relative change of the flow gain per opening of an edge [1/m]: a bowed flow curve. ``0.03 %/µm`` makes
    3 % over 100 µm. None in the paper."""

    null_offset: Annotated[float, SI("m", usual=("1 nm", "1 mm"))] = 0.0
    """Spool position at which the valve is centred on its ports, at the start of the record [m]. The edges
    measure the spool from there; its position and sensor reading count from its own zero. Zero in the
    paper."""

    null_drift: Annotated[float, SI("m/s", usual=("0.01 nm/s", "0.1 mm/s"))] = 0.0
    """Speed at which this position moves over the record [m/s], as with temperature. Zero in the paper."""

    @property
    def angular_frequency(self) -> float:
        """ω_v [rad/s]."""
        return 2.0 * math.pi * self.natural_frequency

    @property
    def position_limit(self) -> float:
        """Largest size of the spool position [m]."""
        return math.inf if self.largest_opening is None else self.largest_opening

    @property
    def speed_limit(self) -> float:
        """Largest size of the spool's speed [m/s]."""
        return math.inf if self.largest_speed is None else self.largest_speed

    @property
    def is_worn(self) -> bool:
        """Whether the edges are rounded, or their gain changes over the stroke."""
        return self.edge_rounding != 0.0 or self.gain_slope != 0.0

    @property
    def is_limited(self) -> bool:
        """Whether position or speed of the spool saturates."""
        return self.largest_opening is not None or self.largest_speed is not None


def require_fluid_fits(fluid: FluidConfig, supply: SupplyConfig) -> None:
    """The chambers do not start cavitating."""
    start = 0.5 * (supply.pressure + supply.return_pressure)
    if fluid.vapour_pressure >= start:
        raise ValueError(
            f"fluid.vapour_pressure = {shown_quantity(fluid.vapour_pressure, 'Pa')} must be below the"
            f" {shown_quantity(start, 'Pa')} at which the chambers start, the mean of supply and return"
            " pressure"
        )
