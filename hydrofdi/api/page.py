"""Tables as HTML, which notebooks show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def html_table(rows: Iterable[Sequence[str]], header: Sequence[str] = (), caption: str = "") -> str:
    """A table; its first column is left-aligned, all others right."""
    parts = [f"<caption>{escape(caption)}</caption>"] if caption else []
    if header:
        parts.append(f"<thead>{_row(header, 'th')}</thead>")
    parts.append(f"<tbody>{''.join(_row(row, 'td') for row in rows)}</tbody>")
    return f"<table>{''.join(parts)}</table>"


def _row(texts: Sequence[str], tag: str) -> str:
    sides = ["left", *("right" for _ in texts[1:])]
    cells = (
        f'<{tag} style="text-align: {side}">{escape(text)}</{tag}>'
        for side, text in zip(sides, texts, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"


def html_sentences(title: str, sentences: Iterable[str]) -> str:
    """A list of sentences below a title."""
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f"<p><strong>{escape(title)}</strong></p><ul>{items}</ul>"
