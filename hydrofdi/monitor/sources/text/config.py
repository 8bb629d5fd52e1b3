"""The format of text streams."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

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

    sampling_frequency: Annotated[float, SI("Hz", above=0.0)] | None = None
    """Sampling frequency of a stream without time; its samples are counted."""

    @property
    def form(self) -> FormatConfig:
        """The same format for a file."""
        return FormatConfig(
            delimiter=self.delimiter, decimal=self.decimal, comment=self.comment, missing=self.missing
        )
