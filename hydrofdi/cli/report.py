"""``hydrofdi report``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Json
from hydrofdi.errors import ReportError

if TYPE_CHECKING:
    from hydrofdi.report import Analysis


class Format(StrEnum):
    """Forms of the report."""

    text = "text"
    markdown = "markdown"
    csv = "csv"
    latex = "latex"
    json = "json"


def report(
    places: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[DIR] [PAGE.html]",
            help="Folder of an experiment [default: the newest below results/]; after --html, the page's file"
            " [default: <name>.html in the folder].",
        ),
    ] = None,
    form: Annotated[Format, typer.Option("--format", help="Form of the report.")] = Format.text,
    html: Annotated[bool, typer.Option("--html", help="Write one self-contained HTML page.")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write all forms and figures to this folder.")
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Draw a figure (.png, .svg, .pdf). Its name says which: figure2, figure3, figure4, spectrum,"
            " mode_plane, phases, readings; any other name draws the heat map of δ.",
        ),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Exit with 1 where a claim that the experiment file lists fails.")
    ] = False,
    json: Json = False,
) -> int:
    """Rebuild the paper's tables from stored results.

    Says which of its sentences they reproduce, and what the controls say of them.
    """
    from hydrofdi.cli.rendering import tell
    from hydrofdi.pipeline import read_results
    from hydrofdi.report import analyze

    directory, page = _places(places or [], html)
    analysis = analyze(read_results(directory))
    if figure is not None:
        from hydrofdi.report.figures import write_figure

        tell(f"drew {figure}: {write_figure(analysis, figure)}")
    if html:
        _write_page(analysis, page or analysis.data.path.with_suffix(".html"))
    if out is not None:
        from hydrofdi.report.publication import write_all_forms

        for line in write_all_forms(analysis, out):
            tell(line)
    if json or form is not Format.text or not (html or out or check):
        _print(analysis, Format.json if json else form)
    return _verdict_code(analysis) if check else 0


def _places(places: list[Path], html: bool) -> tuple[Path | None, Path | None]:
    pages = [place for place in places if place.suffix.lower() == ".html"]
    folders = [place for place in places if place not in pages]
    if len(pages) > 1 or len(folders) > 1:
        raise ReportError("give one folder, and at most one page after --html")
    if pages and not html:
        raise ReportError(f"{pages[0]}: is a page to write only after --html")
    return next(iter(folders), None), next(iter(pages), None)


def _write_page(analysis: Analysis, page: Path) -> None:
    from hydrofdi.cli.rendering import tell
    from hydrofdi.report.publication import write_page

    write_page(analysis, page)
    tell(f"wrote {page}")


def _print(analysis: Analysis, form: Format) -> None:
    from hydrofdi.cli.rendering import print_document, write_out
    from hydrofdi.report import compose_report
    from hydrofdi.report.forms.latex import render_latex
    from hydrofdi.report.forms.markdown import render_markdown
    from hydrofdi.report.forms.record import render_json
    from hydrofdi.report.forms.tidy import render_csv

    match form:
        case Format.text:
            print_document(compose_report(analysis), analysis.data.path)
        case Format.markdown:
            write_out(render_markdown(compose_report(analysis)))
        case Format.latex:
            write_out(render_latex(compose_report(analysis)))
        case Format.csv:
            write_out(render_csv(analysis.table))
        case Format.json:
            write_out(render_json(analysis))


def _verdict_code(analysis: Analysis) -> int:
    """0 where all listed claims are reproduced, else 1."""
    from hydrofdi.cli.rendering import tell

    if not analysis.guarded:
        raise ReportError(
            "--check has nothing to check: list claims in the experiment file, like claims: [C1, C2]"
        )
    for verdict in analysis.guarded:
        word = {True: "holds", False: "does not hold", None: "is not decided"}[verdict.reproduced]
        tell(f"{verdict.claim.id} {word}: {verdict.claim.sentence} (margin {verdict.margin:.2f} points)")
    return 0 if all(verdict.reproduced for verdict in analysis.guarded) else 1
