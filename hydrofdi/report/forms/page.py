"""A report as one self-contained HTML page without scripts or external files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from importlib.resources import files

from hydrofdi.report.document import Block, Cell, Document, Sheet

_SHORT = 16
"""Largest number of rows of a table that stays on one printed page."""

_TERM = 16
"""Largest number of letters of a text that stays on one line, such as ``P1 P2 x u``."""


def render_page(document: Document, figures: Mapping[str, str], captions: Mapping[str, str]) -> str:
    """The report as HTML.

    Parameters
    ----------
    document : Document
    figures : mapping
        Name → ``<svg>`` element, or a paragraph that says why the figure is missing.
    captions : mapping
        Name → caption.
    """
    blocks = [block for block in document.blocks if block.paragraphs or block.sheets or block.figures]
    style = files("hydrofdi.report.forms").joinpath("page.css").read_text(encoding="utf-8")
    title = escape(document.title)
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        '<link rel="icon" href="data:,">',
        f"<title>{title} – hydrofdi</title>",
        f"<style>\n{style}</style>",
        "</head>",
        "<body>",
        f"<header>\n<h1>{title}</h1>",
        *(_paragraph(text) for text in document.lead),
        "</header>",
        *_contents(blocks),
        "<main>",
        *(line for block in blocks for line in _section(block, figures, captions)),
        "</main>",
        "<footer><p>Made by hydrofdi.</p></footer>",
        "</body>",
        "</html>",
    ]
    return "\n".join(lines) + "\n"


def _contents(blocks: list[Block]) -> Iterator[str]:
    yield '<nav aria-label="Sections">\n<ul>'
    for block in blocks:
        yield f'<li><a href="#section-{block.key}">{escape(block.title.partition(":")[0])}</a></li>'
    yield "</ul>\n</nav>"


def _section(block: Block, figures: Mapping[str, str], captions: Mapping[str, str]) -> Iterator[str]:
    yield f'<section id="section-{block.key}">\n<h2>{escape(block.title)}</h2>'
    yield from map(_paragraph, block.paragraphs)
    for sheet in block.shown_sheets:
        yield from _folded(sheet) if sheet.is_folded else _table(sheet)
    for name in block.figures:
        if name in figures:
            yield f'<figure id="{name}" tabindex="0">\n{figures[name]}'
            yield f"<figcaption>{escape(captions[name])}.</figcaption>\n</figure>"
    yield "</section>"


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _folded(sheet: Sheet) -> Iterator[str]:
    yield f"<details>\n<summary>{escape(sheet.title)} ({len(sheet.rows)})</summary>"
    yield from _table(sheet)
    yield "</details>"


def _table(sheet: Sheet) -> Iterator[str]:
    short = " short" if len(sheet.rows) <= _SHORT else ""
    title = escape(sheet.title)
    yield f'<div class="table{short}" role="region" aria-label="{title}" tabindex="0">'
    yield f'<table id="{sheet.key}">\n<caption>{title}</caption>\n<thead>\n<tr>'
    for column, header in enumerate(sheet.headers):
        yield f'<th scope="col"{_words(sheet, column)}>{escape(header)}</th>'
    yield "</tr>\n</thead>\n<tbody>"
    for position, row in enumerate(sheet.rows):
        cells = "".join(
            f"<td{_words(sheet, column, cell.text)}>{_cell(cell)}</td>" for column, cell in enumerate(row)
        )
        row_class = ' class="break"' if position in sheet.breaks else ""
        yield f"<tr{row_class}>{cells}</tr>"
    yield "</tbody>\n</table>"
    if sheet.note:
        yield f'<p class="note">{escape(sheet.note)}</p>'
    yield "</div>"


def _words(sheet: Sheet, column: int, text: str = "") -> str:
    if column not in sheet.text_columns:
        return ""
    return ' class="words term"' if 0 < len(text) <= _TERM else ' class="words"'


def _cell(cell: Cell) -> str:
    text = escape(cell.text)
    if cell.value is not None and cell.value == cell.value:
        text = f'<data value="{escape(str(cell.value))}">{text}</data>'
    return f"<strong>{text}</strong>" if cell.is_strong else text


def missing_figure(reason: str) -> str:
    """The text in place of a figure that could not be drawn."""
    return f'<p class="hole">This figure is missing: {escape(reason)}</p>'
