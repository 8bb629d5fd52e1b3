"""The ``input`` section: the voltage that drives the servovalve."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from hydrofdi.config.sections.csv_input import digest, require_held_text
from hydrofdi.settings.quantities import SI, Section


class InputConfig(Section):
    """Open-loop drive voltage."""

    shape: Literal["square", "steps", "sine", "sweep", "multisine", "csv"] = "square"
    """``square``: +amplitude in the first half of each period, −amplitude in the second (paper). ``steps``:
    seeded pseudo-random levels within ±amplitude, each held for a period. ``sine``: one frequency, 1/period.
    ``sweep``: a sine whose frequency rises linearly over the record, from 1/period to ``end_frequency``.
    ``multisine``: the first ``harmonics`` of 1/period with Schroeder's phases, its peak at ±amplitude.
    ``csv``: the rows of ``file``, which no amplitude scales."""

    amplitude: Annotated[float, SI("V", usual=("1 mV", "100 V"))] = 2.0
    """Amplitude [V]. Axis ticks of Figure 2; 1 V is admissible."""

    period: Annotated[float, SI("s", above=0, usual=("1 ms", "1 h"))] = 2.0
    """Period [s]. A choice; 0.5, 1, 4 and 5 s are admissible."""

    end_frequency: Annotated[float, SI("Hz", above=0, usual=("0.01 Hz", "1 kHz"))] = 20.0
    """Frequency at the end of a sweep [Hz]. A choice, well below the spool's 175 Hz."""

    harmonics: Annotated[int, Field(strict=True, ge=1, le=1000)] = 20
    """Number of harmonics of a multisine. A choice."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of the pseudo-random steps."""

    file: Annotated[str, AfterValidator(require_held_text)] | None = None
    """CSV file of the shape ``csv``: two columns, time and voltage (in closed loop: position), with a
    header such as ``time [ms], voltage [V]`` (without one: s and V). Each value holds until the next row's
    time, the last to the end of the record; a time between two Runge-Kutta steps takes effect at the next
    step. Times rise strictly, from zero or less. At most 100,000 rows. The path is relative to the
    experiment file that names it; the contents become part of the configuration, so that results do not
    need the file any more."""

    @model_validator(mode="after")
    def _file_belongs_to_csv(self) -> Self:
        if self.shape == "csv" and self.file is None:
            raise ValueError("shape csv needs a file: input.file names a CSV file")
        if self.shape != "csv" and self.file is not None:
            raise ValueError(f"input.file needs shape csv; shape is {self.shape}")
        return self

    def stated(self) -> dict[str, Any]:
        """The fields that differ from their defaults; a file by the digest of its contents."""
        fields = super().stated()
        return fields if self.file is None else fields | {"file": digest(self.file)}

    @property
    def factor(self) -> float:
        """What scales the waveform of unit amplitude [V]; a file is not scaled."""
        return 1.0 if self.shape == "csv" else self.amplitude

    @property
    def is_periodic(self) -> bool:
        """Whether the voltage repeats itself after a period."""
        return self.shape in {"square", "sine", "multisine"}
