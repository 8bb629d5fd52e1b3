"""How streams of text are written."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.records.measured.description.sections import Column, FormatConfig, TimeConfig, one_or_more
from hydrofdi.settings.quantities import SI, Section


class TextConfig(Section):
    """How a stream of text is written. What is left out is found from its first lines."""

    delimiter: Annotated[str, Field(min_length=1, max_length=5)] | None = None
    """Sign between the columns: one character, ``tab`` or ``space`` (any run of blanks). Found from the
    header where left out: tab, then ``;``, ``,``, ``|``, blanks."""

    decimal: Literal[".", ","] = "."
    """Decimal sign."""

    comment: str = "#"
    """Lines that start so are left out."""

    missing: Annotated[tuple[Column, ...], one_or_more(str | int)] = ()
    """Texts that stand for a missing value, beside an empty cell, ``nan``, ``NA`` and ``null``."""

    time: TimeConfig | None = None
    """Column or key of sampling instants; by its name where left out."""

    sampling_frequency: Annotated[float, SI("Hz", above=0.0)] | None = None
    """Of a stream without time; its samples are counted then."""

    @property
    def form(self) -> FormatConfig:
        """The same for a file."""
        return FormatConfig(
            delimiter=self.delimiter, decimal=self.decimal, comment=self.comment, missing=self.missing
        )
