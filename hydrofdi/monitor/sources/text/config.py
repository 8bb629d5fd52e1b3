"""The format of text streams."""

from __future__ import annotations

from datetime import tzinfo
from typing import Annotated, Literal

from pydantic import Field, field_validator

from hydrofdi.records.dates import time_zone
from hydrofdi.records.measured.description.sections import Column, FormatConfig, TimeConfig, one_or_more
from hydrofdi.settings.quantities import SI, Section


class TextConfig(Section):
    """Format of a text stream. By default, its header shows the delimiter and the time."""

    delimiter: Annotated[str, Field(min_length=1, max_length=5)] | None = None
    """Separator of the columns: one character, ``tab`` or ``space`` (one or more spaces). By default detected
    from the header: tab, then ``;``, ``,``, ``|``, blanks."""

    decimal: Literal[".", ","] = "."
    """Decimal sign."""

    comment: str = "#"
    """Lines that start with this are ignored."""

    missing: Annotated[tuple[Column, ...], one_or_more(str | int)] = ()
    """Texts that mean a missing value, in addition to an empty cell, ``nan``, ``NA`` and ``null``."""

    time: TimeConfig | None = None
    """Column or key of sampling instants; by default recognised by its name."""

    encoding: str = "utf-8"
    """Encoding, such as ``cp1252`` or ``latin-1``."""

    zone: str = ""
    """Time zone of dates that state none, such as ``Europe/Berlin``, ``UTC`` or ``+01:00``. At the end of
    summer time an hour repeats; zones without summer time avoid that."""

    sampling_frequency: Annotated[float, SI("Hz", above=0.0)] | None = None
    """Sampling frequency of a stream without time; its samples are counted."""

    @field_validator("zone")
    @classmethod
    def _is_a_zone(cls, given: str) -> str:
        if given:
            time_zone(given)
        return given

    @field_validator("encoding")
    @classmethod
    def _is_an_encoding(cls, given: str) -> str:
        try:
            ends = "\n".encode(given)
        except LookupError:
            raise ValueError(f"unknown encoding {given!r}; for example utf-8 or cp1252") from None
        if ends != b"\n":
            raise ValueError(f"{given} is not an encoding of streams; for example utf-8 or cp1252")
        return given

    @property
    def time_zone(self) -> tzinfo | None:
        """The zone; None if it is not stated."""
        return time_zone(self.zone) if self.zone else None

    @property
    def form(self) -> FormatConfig:
        """The same format for a file."""
        return FormatConfig(
            delimiter=self.delimiter, decimal=self.decimal, comment=self.comment, missing=self.missing
        )
