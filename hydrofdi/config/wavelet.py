"""The ``wavelet`` section."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from hydrofdi.config.quantities import Section


def _known_wavelet(name: str) -> str:
    from pywt import wavelist

    if name not in wavelist(kind="discrete"):
        raise ValueError(f"{name!r} is not a discrete wavelet of PyWavelets; the paper uses 'db8'")
    return name


class WaveletConfig(Section):
    """Discrete wavelet transform of the chamber-1 pressure."""

    name: Annotated[str, AfterValidator(_known_wavelet)] = "db8"
    """Name in PyWavelets. db8 has 8 vanishing moments and 16 taps."""

    levels: Annotated[int, Field(strict=True, ge=1, le=20)] = 5
    """Number of levels; d1 is the finest detail."""

    extension: Literal[
        "symmetric", "periodization", "zero", "constant", "periodic", "smooth", "reflect",
        "antisymmetric", "antireflect",
    ] = "symmetric"  # fmt: skip
    """Extension of the record at its ends."""
