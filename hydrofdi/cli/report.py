"""``hydrofdi report``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json


class Format(StrEnum):
    """Forms of the report."""

    text = "text"
    markdown = "markdown"
    csv = "csv"
    latex = "latex"
    json = "json"


def report(
    directory: Annotated[
        Path | None,
        typer.Argument(metavar="[DIR]", help="Folder of an experiment [default: the newest below results/]."),
    ] = None,
    form: Annotated[Format, typer.Option("--format", help="Form of the report.")] = Format.text,
    figure: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Draw the table as a heat map (.png, .svg, .pdf).")
    ] = None,
    json: Json = False,
) -> int:
    """Rebuild Table 3 from stored results, with sealed control rows and both baselines."""
    from hydrofdi.cli.rendering import print_table, tell, write_out
    from hydrofdi.pipeline import newest_experiment_file
    from hydrofdi.report import render_csv, render_json, render_latex, render_markdown, summarize_table
    from hydrofdi.store import read_experiment

    file = newest_experiment_file(directory)
    table = summarize_table(read_experiment(file))
    renderers = {
        Format.markdown: render_markdown,
        Format.csv: render_csv,
        Format.latex: render_latex,
        Format.json: render_json,
    }
    form = Format.json if json else form
    if figure is not None:
        from hydrofdi.report.figures import draw_sensitivity, save_figure

        save_figure(draw_sensitivity(table), figure)
        tell(f"drew {figure}")
    if form is Format.text:
        print_table(table, file)
    else:
        write_out(renderers[form](table))
    return 0
