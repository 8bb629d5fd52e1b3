"""The ``input`` section: the voltage that drives the servovalve."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.config.quantities import SI, Section


class InputConfig(Section):
    """Open-loop drive voltage."""

    shape: Literal["square", "steps", "sine", "sweep", "multisine"] = "square"
    """``square``: +amplitude in the first half of each period, −amplitude in the second (paper). ``steps``:
    seeded pseudo-random levels within ±amplitude, each held for a period. ``sine``: one frequency, 1/period.
    ``sweep``: a sine whose frequency rises linearly over the record, from 1/period to ``end_frequency``.
    ``multisine``: the first ``harmonics`` of 1/period with Schroeder's phases, its peak at ±amplitude."""

    amplitude: Annotated[float, SI("V")] = 2.0
    """Amplitude [V]. Axis ticks of Figure 2; 1 V is admissible."""

    period: Annotated[float, SI("s", above=0)] = 2.0
    """Period [s]. A choice; 0.5, 1, 4 and 5 s are admissible."""

    end_frequency: Annotated[float, SI("Hz", above=0)] = 20.0
    """Frequency at the end of a sweep [Hz]. A choice, well below the spool's 175 Hz."""

    harmonics: Annotated[int, Field(strict=True, ge=1, le=1000)] = 20
    """Number of harmonics of a multisine. A choice."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of the pseudo-random steps."""

    @property
    def is_periodic(self) -> bool:
        """Whether the voltage repeats itself after a period."""
        return self.shape in {"square", "sine", "multisine"}

    @property
    def is_smooth(self) -> bool:
        """Whether the voltage has no jumps but those from step to step."""
        return self.shape in {"sine", "sweep", "multisine"}
