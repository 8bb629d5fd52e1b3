"""A report as one self-contained HTML page, as Markdown, and all its forms as files."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from hydrofdi.errors import ReportError
from hydrofdi.report.document import Block, Document
from hydrofdi.store.files import require_own, whole_file
from hydrofdi.tables.table import Table, escaped, latex

if TYPE_CHECKING:
    from hydrofdi.report.document import ComposedReport

_BEFORE_ROOT = re.compile(r".*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_IDENTITY = re.compile(r'\bid="([^"]+)"')
_REFERENCE = re.compile(r'(url\(#|href="#)([^")]+)')


def inline_svg(svg: str, name: str, label: str, colors: dict[str, str]) -> str:
    """An SVG file as an element of a page."""
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
    """The report as HTML."""
    blocks = [block for block in document.blocks if block.paragraphs or block.shown_tables or block.figures]
    style, frame = (
        files("hydrofdi.report").joinpath(f"page.{each}").read_text("utf-8") for each in ("css", "html")
    )
    links = (
        f'<li><a href="#section-{block.key}">{escape(block.title.partition(":")[0])}</a></li>'
        for block in blocks
    )
    return Template(frame).substitute(
        title=escape(document.title),
        style=style,
        lead=escape(document.lead),
        contents="\n".join(links),
        sections="\n".join(line for block in blocks for line in _section(block, figures, captions)),
    )


def _section(block: Block, figures: Mapping[str, str], captions: Mapping[str, str]) -> Iterator[str]:
    yield f'<section id="section-{block.key}">\n<h2>{escape(block.title)}</h2>'
    yield from (f"<p>{escape(text)}</p>" for text in block.paragraphs)
    yield from map(_table, block.shown_tables)
    for name in block.figures:
        if name in figures:
            yield f'<figure id="{name}" tabindex="0">\n{figures[name]}'
            yield f"<figcaption>{escape(captions[name])}.</figcaption>\n</figure>"
    yield "</section>"


def _table(table: Table) -> str:
    short = " short" if len(table) <= _SHORT else ""
    region = f'<div class="table{short}" role="region" aria-label="{escape(table.title)}" tabindex="0">'
    return f"{region}{table.to_html()}</div>"


def render_json(report: ComposedReport) -> str:
    """A report as JSON."""
    return json.dumps(report.record(), indent=2, allow_nan=False) + "\n"


def render_markdown(document: Document) -> str:
    """The report in Markdown, without figures."""
    parts = [f"# {document.title}", document.lead]
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


def render_latex(document: Document) -> str:
    """The tables of the answers for LaTeX; they need the package booktabs."""
    tables = [table for block in document.blocks if block.is_answer for table in block.shown_tables]
    if not tables:
        raise ReportError("the report has no table as its answer; --format markdown has all tables")
    parts = (
        "\n".join(
            [
                r"\begin{table}",
                r"\centering",
                rf"\caption{{{latex(table.title or document.title)}}}",
                table.to_latex(),
                *(rf"\par\smallskip\footnotesize {latex(note)}" for note in table.notes),
                r"\end{table}",
            ]
        )
        for table in tables
    )
    return "% \\usepackage{booktabs}\n" + "\n\n".join(parts) + "\n"


_WHAT = "a report of hydrofdi"
_LEAD_LETTERS = 20


def write_page(report: ComposedReport, path: Path) -> None:
    """Write the HTML page."""
    from hydrofdi.report.figures import draw_all

    document = report.document()
    require_own(path, _own(document)["html"], _WHAT)
    drawn, holes = draw_all(report, document.figures)
    _write(path, _page(report, document, _svg_texts(drawn), holes).encode())


def write_all_forms(report: ComposedReport, directory: Path) -> Iterator[str]:
    """Write every form and figure into a folder; yields a line on each."""
    from hydrofdi.report.figures import KINDS, draw_all, figure_bytes

    document, name = report.document(), report.name
    for suffix, own in _own(document).items():
        require_own(directory / f"{name}.{suffix}", own, _WHAT)
    drawn, holes = draw_all(report, document.figures)
    svgs = _svg_texts(drawn)
    texts = {
        "md": render_markdown(document),
        "csv": Table.of(report.columns()).to_csv(),
        "json": render_json(report),
        "html": _page(report, document, svgs, holes),
    }
    for suffix, text in texts.items():
        yield _write(directory / f"{name}.{suffix}", text.encode())
    try:
        yield _write(directory / f"{name}.parquet", Table.of(report.columns()).to_parquet())
    except ReportError as error:
        yield f"left out {name}.parquet: {error}"
    for figure_name, figure in drawn.items():
        for kind in KINDS:
            content = svgs[figure_name].encode() if kind == "svg" else figure_bytes(figure, kind)
            yield _write(directory / f"{figure_name}.{kind}", content)
    for figure_name, why in holes.items():
        yield f"left out {figure_name}: {why}"


def _own(document: Document) -> dict[str, re.Pattern[bytes]]:
    """Suffix → first and last bytes of the report of this experiment, with whatever results."""
    lead = document.lead[:_LEAD_LETTERS]
    return {
        "md": re.compile(re.escape(f"# {document.title}\n\n{lead}").encode()),
        "csv": re.compile(rb"[^\n]*\b(run_id|indicator)\b"),
        "json": re.compile(rb'\{\n  "experiment": '),
        "html": re.compile(rb".{,500} hydrofdi</title>", re.DOTALL),
        "parquet": re.compile(rb"PAR1.*\b(run_id|indicator)\b", re.DOTALL),
    }


def _svg_texts(drawn: Mapping[str, Any]) -> dict[str, str]:
    from hydrofdi.report.figures import figure_bytes

    return {name: figure_bytes(figure, "svg").decode() for name, figure in drawn.items()}


def _page(
    report: ComposedReport, document: Document, svgs: Mapping[str, str], holes: Mapping[str, str]
) -> str:
    from hydrofdi.report.figures import INK, PAPER, RULE

    colors = {INK: "var(--ink)", RULE: "var(--rule)", PAPER: "var(--paper)"}
    captions = {name: figure.caption for name, figure in report.figures().items()}
    elements = {name: inline_svg(svg, name, captions[name], colors) for name, svg in svgs.items()}
    missing = {
        name: f'<p class="hole">This figure is missing: {escape(why)}</p>' for name, why in holes.items()
    }
    return render_page(document, elements | missing, captions)


def _write(path: Path, content: bytes) -> str:
    with whole_file(path) as aside:
        aside.write_bytes(content)
    return f"wrote {path}"
