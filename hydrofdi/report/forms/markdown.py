"""A report as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hydrofdi.report.document import Block, Cell, Document, Sheet


def render_markdown(document: Document) -> str:
    """The report in Markdown, without figures."""
    parts = [f"# {document.title}", *document.lead]
    for block in document.blocks:
        parts += _block(block)
    return "\n\n".join(parts) + "\n"


def _block(block: Block) -> Iterator[str]:
    if not (block.paragraphs or block.sheets):
        return
    yield f"## {block.title}"
    yield from map(_escaped, block.paragraphs)
    for sheet in block.shown_sheets:
        yield f"### {sheet.title}"
        yield "\n".join(_sheet_lines(sheet))
        if sheet.note:
            yield sheet.note


def _sheet_lines(sheet: Sheet) -> Iterator[str]:
    yield _pipe(sheet.headers)
    yield _pipe(["---" if column in sheet.text_columns else "---:" for column in range(len(sheet.headers))])
    for row in sheet.rows:
        yield _pipe([_cell(cell) for cell in row])


def _cell(cell: Cell) -> str:
    text = _escaped(cell.text)
    return f"**{text}**" if cell.is_strong else text


def _escaped(text: str) -> str:
    return text.replace("|", r"\|").replace("*", r"\*")


def _pipe(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
