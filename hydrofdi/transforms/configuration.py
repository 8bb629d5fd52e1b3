"""The ``wavelet`` section."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from hydrofdi.settings.messages import similar
from hydrofdi.settings.quantities import Section


def _known_wavelet(name: str) -> str:
    from pywt import wavelist

    known = wavelist(kind="discrete")
    if name not in known:
        hint = similar(name, known) or ", such as 'db8'"
        raise ValueError(f"{name!r} is not a discrete wavelet of PyWavelets{hint}")
    return name


def _phase(value: Any) -> Any:
    if value == "all" or (isinstance(value, int) and not isinstance(value, bool) and value >= 0):
        return value
    raise ValueError(f"must be an integer from 0 to 2^levels − 1, or 'all'; found {value!r}")


WaveletName = Annotated[str, AfterValidator(_known_wavelet)]
"""Name of a discrete wavelet in PyWavelets."""

Levels = Annotated[int, Field(strict=True, ge=1, le=20)]
"""Number of levels of a transform."""

Extension = Literal[
    "symmetric", "periodization", "zero", "constant", "periodic", "smooth", "reflect",
    "antisymmetric", "antireflect",
]  # fmt: skip
"""Signal extension at the ends of a record; names as in PyWavelets."""


class WaveletConfig(Section):
    """Discrete wavelet transform of the chamber-1 pressure."""

    name: WaveletName = "db8"
    """Name in PyWavelets. db8 has 8 vanishing moments and 16 taps."""

    levels: Levels = 5
    """Number of levels; d1 is the finest detail."""

    extension: Extension = "symmetric"
    """Extension of the record at its ends."""

    boundary: Literal["kept", "left_out"] = "kept"
    """Whether coefficients that depend on the extension are used."""

    phase: Annotated[int | Literal["all"], Field(union_mode="left_to_right"), BeforeValidator(_phase)] = 0
    """First sample of the analysed record, counted after ``analysis.discard``. The transform is decimated, so
    its coefficients depend on where the grid of 2^levels samples starts. ``all`` measures every phase from 0
    to 2^levels − 1 in addition to phase 0."""

    @model_validator(mode="after")
    def _phase_is_one_of_the_grid(self) -> Self:
        if isinstance(self.phase, int) and self.phase >= 2**self.levels:
            raise ValueError(
                f"phase = {self.phase} must be below 2^levels = {2**self.levels}, where the phases repeat"
            )
        return self

    @model_validator(mode="after")
    def _inner_coefficients_are_known(self) -> Self:
        if self.boundary == "left_out" and self.extension == "periodization":
            raise ValueError("boundary = left_out cannot be combined with extension = periodization")
        return self

    @property
    def first_sample(self) -> int:
        """First sample of the analysed record."""
        return self.phase if isinstance(self.phase, int) else 0

    @property
    def latest_start(self) -> int:
        """Largest phase that is measured."""
        return self.phase if isinstance(self.phase, int) else 2**self.levels - 1
