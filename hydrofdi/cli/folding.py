"""Names and sentences folded into lines, never inside a part of a name."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.text import Text


def folded(text: str, width: int) -> list[str]:
    """A text in lines of at most `width`: broken at blanks, and long words after dots and underscores.

    A part of a name is cut only if it is longer than a line. A mark of one character stays with the word
    before it.
    """
    lines = [""]
    for word in _words(text):
        if lines[-1] and len(lines[-1]) + 1 + len(word) <= width:
            lines[-1] += f" {word}"
            continue
        if lines[-1]:
            lines.append("")
        for piece in _pieces(word, width) if len(word) > width else [word]:
            if lines[-1] and len(lines[-1]) + len(piece) > width:
                lines.append("")
            lines[-1] += piece
    return lines


def _words(text: str) -> list[str]:
    return re.split(r"\s+(?!\S(?:\s|$))", text.strip())


def _pieces(word: str, width: int) -> list[str]:
    parts: list[str] = re.findall(r"[^._]*[._]|[^._]+", word)
    return [part[start : start + width] for part in parts for start in range(0, len(part), width)]


@dataclass(frozen=True)
class Folded:
    """A table cell that is folded at the width of its column."""

    text: str
    style: str = ""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The lines of the cell."""
        yield Text("\n".join(folded(self.text, options.max_width)), style=self.style)

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """The width of its longest part, and of the whole text in a line."""
        parts = (part for word in _words(self.text) for part in _pieces(word, options.max_width))
        return Measurement(max(map(len, parts), default=0), len(self.text))
