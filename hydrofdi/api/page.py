"""Tables as HTML, which notebooks show."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

_NUMBER = re.compile(r"[-+−]?(\d[\d,]*(\.\d*)?(e[-+]?\d+)?|inf|nan)(\s|%|$)")


def html_table(rows: Iterable[Sequence[str]], header: Sequence[str] = (), caption: str = "") -> str:
    """A table; columns of numbers are right-aligned, all others left."""
    rows = [*rows]
    sides = ["right" if _are_numbers(column) else "left" for column in zip(*rows, strict=True)]
    sides = sides or ["left" for _ in header]
    parts = [f"<caption>{escape(caption)}</caption>"] if caption else []
    if header:
        parts.append(f"<thead>{_row(header, 'th', sides)}</thead>")
    parts.append(f"<tbody>{''.join(_row(row, 'td', sides) for row in rows)}</tbody>")
    return f"<table>{''.join(parts)}</table>"


def _are_numbers(column: Sequence[str]) -> bool:
    """Whether most texts of a column are numbers."""
    stated = [text for text in column if text]
    return 2 * sum(_NUMBER.match(text) is not None for text in stated) > len(stated)


def _row(texts: Sequence[str], tag: str, sides: Sequence[str]) -> str:
    cells = (
        f'<{tag} style="text-align: {side}">{escape(text)}</{tag}>'
        for side, text in zip(sides, texts, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"


def html_sentences(title: str, sentences: Iterable[str]) -> str:
    """A list of sentences below a title."""
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f"<p><strong>{escape(title)}</strong></p><ul>{items}</ul>"
