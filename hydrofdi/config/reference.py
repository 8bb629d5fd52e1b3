"""The ``reference`` section: published values to compare with."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from hydrofdi.settings.quantities import SI, Section


class ReferenceCell(Section):
    """One published number."""

    leakage: Annotated[float, SI("m^3/s", least=0)]
    """Leakage level of the row [m³/s]; 0 for the sealed actuator."""

    bulk_modulus: Annotated[float, SI("Pa", above=0)]
    """EBM of the row [Pa]."""

    level: Annotated[str, Field(pattern=r"^d[1-9][0-9]?$")]
    """Level of the column: d1, d2, …"""

    delta: Annotated[float, SI("%")] | None = None
    """Published δ against the fixed baseline [%]."""

    rms: Annotated[float, SI("Pa", above=0)] | None = None
    """Published RMS [Pa]."""

    tolerance: Annotated[float, SI("%", least=0)] | None = None
    """Allowed deviation of the computed value: percentage points of δ, percent of a published RMS."""

    @model_validator(mode="after")
    def _one_published_number(self) -> Self:
        if (self.delta is None) == (self.rms is None):
            raise ValueError("give one of delta and rms")
        return self


class ReferenceConfig(Section):
    """Published values."""

    source: str = ""
    """Publication that contains the numbers."""

    tolerance: Annotated[float, SI("%", least=0)] = 0.5
    """Default tolerance of the cells: percentage points of δ, percent of a published RMS."""

    cells: tuple[ReferenceCell, ...] = ()
    """The published numbers."""
