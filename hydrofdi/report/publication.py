"""All forms of a report as files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from hydrofdi.errors import ReportError
from hydrofdi.report.document import ComposedReport, Document
from hydrofdi.report.figures import KINDS, draw_all
from hydrofdi.report.figures.style import INK, PAPER, RULE, figure_bytes
from hydrofdi.report.forms.page import inline_svg, missing_figure, render_markdown, render_page
from hydrofdi.report.record import render_json
from hydrofdi.report.table import Table
from hydrofdi.store.files import require_own, whole_file

_WHAT = "a report of hydrofdi"
_LEAD_LETTERS = 20

_PAGE_COLORS = {INK: "var(--ink)", RULE: "var(--rule)", PAPER: "var(--paper)"}


def write_page(report: ComposedReport, path: Path) -> None:
    """Write the HTML page.

    Raises
    ------
    StoreError
        It cannot be written, or something else exists there.
    """
    document = report.document()
    require_own(path, _own(document)["html"], _WHAT)
    drawn, holes = draw_all(report, document.figures)
    _write(path, _page(report, document, _svg_texts(drawn), holes).encode())


def write_all_forms(report: ComposedReport, directory: Path) -> Iterator[str]:
    """Write every form and figure into a folder; yields a line on each.

    Raises
    ------
    StoreError
        The folder cannot be written, or a file of something else would be replaced; then nothing is written.
    """
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
    lead = "".join(document.lead)[:_LEAD_LETTERS]
    return {
        "md": re.compile(re.escape(f"# {document.title}\n\n{lead}").encode()),
        "csv": re.compile(rb"[^\n]*\b(run_id|indicator)\b"),
        "json": re.compile(rb'\{\n  "experiment": '),
        "html": re.compile(rb".{,500} hydrofdi</title>", re.DOTALL),
        "parquet": re.compile(rb"PAR1.*\b(run_id|indicator)\b", re.DOTALL),
    }


def _svg_texts(drawn: Mapping[str, Any]) -> dict[str, str]:
    return {name: figure_bytes(figure, "svg").decode() for name, figure in drawn.items()}


def _page(
    report: ComposedReport, document: Document, svgs: Mapping[str, str], holes: Mapping[str, str]
) -> str:
    captions = {name: figure.caption for name, figure in report.figures().items()}
    elements = {name: inline_svg(svg, name, captions[name], _PAGE_COLORS) for name, svg in svgs.items()}
    missing = {name: missing_figure(why) for name, why in holes.items()}
    return render_page(document, elements | missing, captions)


def _write(path: Path, content: bytes) -> str:
    with whole_file(path) as aside:
        aside.write_bytes(content)
    return f"wrote {path}"
