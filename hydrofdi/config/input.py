"""The ``input`` section: the voltage that drives the servovalve."""

from __future__ import annotations

from typing import Annotated, Literal

from hydrofdi.config.quantities import SI, Section


class InputConfig(Section):
    """Open-loop drive voltage."""

    shape: Literal["square"] = "square"
    """``square``: +amplitude in the first half of each period, −amplitude in the second."""

    amplitude: Annotated[float, SI("V")] = 2.0
    """Amplitude [V]. Axis ticks of Figure 2; 1 V is admissible."""

    period: Annotated[float, SI("s", above=0)] = 2.0
    """Period [s]. A choice; 0.5, 1, 4 and 5 s are admissible."""
