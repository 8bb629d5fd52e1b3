"""``hydrofdi report``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from hydrofdi.cli.options import Json
from hydrofdi.cli.terminal import tell, write_out
from hydrofdi.errors import ReportError

if TYPE_CHECKING:
    from hydrofdi.report.table import ComposedReport


def report(
    places: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[DIR] [PAGE.html]",
            help="Folder of an experiment [default: the newest in results/]; with --html, the page's file"
            " [default: <name>.html in the folder].",
        ),
    ] = None,
    form: Annotated[
        Literal["text", "markdown", "csv", "json", "html"] | None,
        typer.Option(
            "--format", help="Format of the report [default: text]; html writes a page, as --html does."
        ),
    ] = None,
    html: Annotated[bool, typer.Option("--html", help="Write one self-contained HTML page.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR|FILE", help="Write all formats and figures to this folder; or one figure to a file."
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="NAME",
            help="Draw this figure to --out FILE (.png, .svg, .pdf), or to NAME.svg. Any sweep: responses,"
            " sensitivity (a heat map of δ). A study of detection: answer, ranking, pod, roc, det,"
            " false_alarms, densities, tornado, delays. With 'paper: maddahi2015': figure2, figure3, figure4,"
            " spectrum, mode_plane, phases, scenarios.",
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option("--check", help="Exit with code 1 if a claim that the experiment file lists fails."),
    ] = False,
    full: Annotated[
        bool,
        typer.Option("--full", help="On the terminal, show all tables and rows, not only the first page."),
    ] = False,
    json: Json = False,
) -> int:
    """Show stored results as tables and figures.

    A sweep: what was varied, against which baseline, and how each feature responds. A study of detection:
    which leak is found, with which sensors and which score. The study of a paper: its tables and claims.
    """
    from hydrofdi.api.results import load
    from hydrofdi.config.shown_values import shown_in

    html = html or form == "html"
    directory, page = _places(places or [], html)
    results = load(directory)
    with shown_in(results.data.experiment.units):
        made = results.composed
        if figure is not None:
            from hydrofdi.report.figures import write_figure

            target = figure if figure.suffix else out
            if target is None:
                raise ReportError(f"--figure {figure}: add --out FILE, or write --figure {figure}.svg")
            tell(f"drew {target}: {write_figure(made, target, figure.stem)}")
            out = out if figure.suffix else None
        if html:
            from hydrofdi.report.forms.page import write_page

            page = page or made.path.with_suffix(".html")
            write_page(made, page)
            tell(f"wrote {page}")
        if out is not None:
            from hydrofdi.report.forms.page import write_all_forms

            tell(*write_all_forms(made, out))
        if json or form not in (None, "html") or not (html or out or check or figure):
            _print(made, "json" if json else form or "text", full)
        return _check_code(made) if check else 0


def _places(places: list[Path], html: bool) -> tuple[Path | None, Path | None]:
    if html and len(places) == 2 and (other := places[1]).suffix.lower() != ".html":
        raise ReportError(f"{other}: the name of a page must end in .html")
    pages = [place for place in places if place.suffix.lower() == ".html"]
    folders = [place for place in places if place not in pages]
    if len(pages) > 1 or len(folders) > 1:
        raise ReportError("give one folder, and at most one page after --html")
    if pages and not html:
        raise ReportError(f"{pages[0]}: put the page to write after --html")
    return next(iter(folders), None), next(iter(pages), None)


def _print(made: ComposedReport, form: str, full: bool) -> None:
    from hydrofdi.cli.tables import print_document
    from hydrofdi.report.forms.page import render_markdown
    from hydrofdi.report.record import render_json
    from hydrofdi.report.table import Table

    if form == "text":
        print_document(made.document(), made.path, full=full)
    elif form == "markdown":
        write_out(render_markdown(made.document()))
    else:
        write_out(Table.of(made.columns()).to_csv() if form == "csv" else render_json(made))


def _check_code(made: ComposedReport) -> int:
    """0 if all claims that the experiment file lists hold, else 1."""
    checks = made.checks()
    if not checks:
        raise ReportError(
            "--check has nothing to check: list claims in the experiment file, for example claims: [C1, C2]"
        )
    tell(*checks)
    return 0 if all(checks.values()) else 1
