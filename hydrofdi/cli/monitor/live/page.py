"""The size of a terminal, and the headings of its parts."""

from __future__ import annotations

from dataclasses import dataclass

from rich.text import Text

LABEL_WIDTH = 9
"""Width of the numbers beside a plot [columns]."""


@dataclass(frozen=True)
class Page:
    """Size of a terminal.

    Attributes
    ----------
    width, height : int
        Columns and lines.
    plain : bool
        Whether it shows only ASCII.
    """

    width: int
    height: int
    plain: bool = False

    @property
    def plot_width(self) -> int:
        """Columns of a plot beside its labels."""
        return self.width - LABEL_WIDTH - 1


def heading(text: str, page: Page, aside: str = "") -> Text:
    """The heading of a part of the screen; `aside` is omitted if the line is full."""
    n_free = page.width - len(text) - len(aside) - 1
    if n_free < 1:
        n_free, aside = max(page.width - len(text) - 1, 0), ""
    return Text.assemble((text, "bold"), f" {('-' if page.plain else '─') * n_free}", aside)
