"""The ``valve`` section: a second-order servovalve with symmetric ports."""

from __future__ import annotations

import math
from typing import Annotated

from hydrofdi.settings import usual
from hydrofdi.settings.quantities import SI, Section


class ValveConfig(Section):
    """Servovalve."""

    flow_gain: Annotated[
        float, SI("m^1.5/kg^0.5", above=0, usual=("0.001 m^1.5/kg^0.5", "0.5 m^1.5/kg^0.5"))
    ] = 0.0292
    """Flow gain K_v [m^1.5/kg^0.5], 0.6 √(2/ρ) with ρ = 847 kg/m³. Table 1, legible as ".9"."""

    area_gradient: Annotated[float, SI("m", above=0, usual=("0.1 mm", "1 m"))] = 20.75e-3
    """Orifice area gradient w [m]. Low confidence: lost in Table 1, from sister works."""

    spool_gain: Annotated[float, SI("m/V", above=0, usual=("10 nm/V", "10 mm/V"))] = 22e-6
    """Spool position gain k_v [m/V]. Medium confidence; 27.9 and 40.6 µm/V are admissible."""

    natural_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "10 kHz"))] = 175.0
    """Undamped natural frequency of the spool [Hz]; ω_v = 2π times it. Table 1, legible as "175"."""

    damping_ratio: Annotated[float, SI("1", above=0, usual=("0.05", "5"))] = 0.7
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

    lap_leakage: Annotated[
        float, SI("m^3/(s*Pa)", least=0, usual=("1e-18 m^3/(s*Pa)", "1e-8 m^3/(s*Pa)"))
    ] = 0.0
    """Conductance of the clearance over each of the four edges [m³/(s·Pa)]. None in the paper."""

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
    def is_shifted(self) -> bool:
        """Whether the ports are centred anywhere but at the zero of the spool."""
        return self.null_offset != 0.0 or self.null_drift != 0.0

    def largest_null(self, duration: float) -> float:
        """Largest size of the null over a record of that length [m]."""
        return max(abs(self.null_offset), abs(self.null_offset + self.null_drift * duration))

    @property
    def is_limited(self) -> bool:
        """Whether position or speed of the spool saturates."""
        return self.largest_opening is not None or self.largest_speed is not None
