"""What scores and charts have in common: a name, what it is, and options."""

from __future__ import annotations

from typing import Any, ClassVar, Generic, TypeVar

from hydrofdi.settings.quantities import Section

Chosen = TypeVar("Chosen", bound=Section)


class Method(Generic[Chosen]):
    """A score or a chart.

    Attributes
    ----------
    name : str
        Name in files and on the command line.
    summary : str
        What it computes, in one sentence.
    caution : str
        Limitations that users must know.
    Options : type of Section
        Model of its options; all of them have defaults.
    options : Section
        Options of this instance.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    caution: ClassVar[str]
    Options: ClassVar[type[Section]] = Section
    options: Chosen

    def __init__(self, options: Chosen | None = None) -> None:
        chosen: Any = self.Options() if options is None else options
        self.options = chosen
