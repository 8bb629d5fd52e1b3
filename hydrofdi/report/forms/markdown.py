"""A report as Markdown."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.report.document import Block, Document
from hydrofdi.report.table import escaped


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
