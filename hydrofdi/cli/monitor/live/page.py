"""The room that a terminal has, and how its parts begin."""

from __future__ import annotations

from dataclasses import dataclass

from rich.text import Text

LABEL_WIDTH = 9
"""Columns of the numbers beside a plot."""


@dataclass(frozen=True)
class Page:
    """Room of a terminal.

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
    """A line that begins a part of the screen; what is secondary gives way where the line is full."""
    n_free = page.width - len(text) - len(aside) - 1
    if n_free < 1:
        n_free, aside = max(page.width - len(text) - 1, 0), ""
    return Text.assemble((text, "bold"), f" {('-' if page.plain else '─') * n_free}", aside)
