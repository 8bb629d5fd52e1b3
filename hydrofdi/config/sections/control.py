"""The ``control`` section: what drives the valve, a voltage as such or a position controller."""

from __future__ import annotations

from typing import Annotated, Literal

from hydrofdi.settings import usual
from hydrofdi.settings.quantities import SI, Section


class ControlConfig(Section):
    """Open loop, or closed loop on the piston position."""

    law: Literal["open", "p", "pi", "pid"] = "open"
    """``open``: the input is the voltage of the valve (paper). ``p``, ``pi``, ``pid``: the input is a
    reference for the position, which a sampled controller tracks through the voltage."""

    feedback: Literal["ideal", "measured"] = "ideal"
    """Position used by the controller. ``ideal``: the true position. ``measured``: what ``position_sensor``
    shows, with bias, drift, white noise, range and resolution. Lags, filter and jitter belong to the record
    and stay out of the loop. Where controller and record sample at the same instant, they read the same
    position if the sensor has no lag and ``measurement`` neither filter nor jitter, and its noise is not a
    density or the controller samples as often as the record."""

    amplitude: Annotated[float, SI("m", usual=usual.POSITION)] = 20e-3
    """Amplitude of the position reference [m]; its shape and period are those of the input. A choice."""

    proportional_gain: Annotated[float, SI("V/m", least=0, usual=("0.01 V/m", "1000000 V/m"))] = 100.0
    """Gain K_p [V/m]. A choice: a crossover near 1 Hz, well below the hydraulic mode."""

    integral_gain: Annotated[float, SI("V/(m*s)", least=0, usual=("0.01 V/(m*s)", "1e7 V/(m*s)"))] = 100.0
    """Gain K_I of the laws ``pi`` and ``pid`` [V/(m·s)]. A choice. The integral is frozen while the voltage
    is limited and the error would drive it further (anti-windup)."""

    derivative_gain: Annotated[float, SI("V*s/m", least=0, usual=("1e-5 V*s/m", "10000 V*s/m"))] = 0.5
    """Gain K_D of the law ``pid`` [V·s/m]. A choice."""

    sample_time: Annotated[float, SI("s", above=0, usual=("1 µs", "1 s"))] = 2e-3
    """Sampling interval of the controller [s]; the voltage is held in between. A choice."""

    voltage_limit: Annotated[float, SI("V", above=0, usual=usual.VOLTAGE)] = 5.0
    """Largest magnitude of the voltage [V]. A choice."""

    @property
    def is_closed(self) -> bool:
        """Whether a controller drives the valve."""
        return self.law != "open"

    @property
    def is_measured(self) -> bool:
        """Whether a controller reads the sensor of the position."""
        return self.is_closed and self.feedback == "measured"

    @property
    def used_integral_gain(self) -> float:
        """K_I, or 0 where the law has none [V/(m·s)]."""
        return self.integral_gain if self.law in {"pi", "pid"} else 0.0

    @property
    def used_derivative_gain(self) -> float:
        """K_D, or 0 where the law has none [V·s/m]."""
        return self.derivative_gain if self.law == "pid" else 0.0
