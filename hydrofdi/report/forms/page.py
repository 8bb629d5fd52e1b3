"""A report as one self-contained HTML page, and as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from html import escape
from importlib.resources import files

from hydrofdi.report.document import Block, Document
from hydrofdi.report.table import Table, escaped

_BEFORE_ROOT = re.compile(r".*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_IDENTITY = re.compile(r'\bid="([^"]+)"')
_REFERENCE = re.compile(r'(url\(#|href="#)([^")]+)')


def inline_svg(svg: str, name: str, label: str, colors: dict[str, str]) -> str:
    """An SVG file as an element of a page.

    Parameters
    ----------
    svg : str
        The text of the file.
    name : str
        Put before all ids, so that figures of one page do not share any.
    label : str
        What the figure shows, in words.
    colors : dict
        Colour in the file → CSS colour in the page.
    """
    text = _METADATA.sub("", _BEFORE_ROOT.sub("", svg, count=1))
    text = re.sub(r'\s(?:width|height)="[\d.]+pt"', "", text, count=2)
    text = _IDENTITY.sub(rf'id="{name}-\1"', text)
    text = _REFERENCE.sub(rf"\g<1>{name}-\2", text)
    for old, new in colors.items():
        text = text.replace(old, new)
    return text.replace("<svg", f'<svg role="img" aria-label="{escape(label)}"', 1).strip()


_SHORT = 16
"""Largest number of rows of a table that stays on one printed page."""


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
    blocks = [block for block in document.blocks if block.paragraphs or block.shown_tables or block.figures]
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
    for table in block.shown_tables:
        yield from _table(table)
    for name in block.figures:
        if name in figures:
            yield f'<figure id="{name}" tabindex="0">\n{figures[name]}'
            yield f"<figcaption>{escape(captions[name])}.</figcaption>\n</figure>"
    yield "</section>"


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _table(table: Table) -> Iterator[str]:
    short = " short" if len(table) <= _SHORT else ""
    shown = f'<div class="table{short}" role="region" aria-label="{escape(table.title)}" tabindex="0">'
    shown += f"{table.to_html()}</div>"
    summary = f"<summary>{escape(table.title)} ({len(table)})</summary>"
    yield f"<details>\n{summary}\n{shown}\n</details>" if table.is_folded else shown


def missing_figure(reason: str) -> str:
    """The text in place of a figure that could not be drawn."""
    return f'<p class="hole">This figure is missing: {escape(reason)}</p>'


def render_markdown(document: Document) -> str:
    """The report in Markdown, without figures."""
    parts = [f"# {document.title}", *document.lead]
    for block in document.blocks:
        parts += _block(block)
    return "\n\n".join(parts) + "\n"


def _block(block: Block) -> Iterator[str]:
    if not (block.paragraphs or block.shown_tables):
        return
    yield f"## {block.title}"
    yield from map(escaped, block.paragraphs)
    for table in block.shown_tables:
        yield from (*([f"### {table.title}"] if table.title else []), table.to_markdown(), *table.notes)
