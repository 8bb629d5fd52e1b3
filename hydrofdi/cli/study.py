"""``hydrofdi plan``, ``sweep``, ``status``, ``collect``, ``calibrate``, ``report``, and the audit of runs."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import hydrofdi
from hydrofdi.cli.options import Config, Directory, Found, Grid, Json, Name, Settings, Sweep, Write, Zip
from hydrofdi.cli.terminal import answer, tell, write_out
from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.settings.messages import counted

if TYPE_CHECKING:
    from hydrofdi.config import ExperimentConfig
    from hydrofdi.report.document import ComposedReport


_FEW_ROWS = 12
"""Rows of an answer."""


def sweep(
    config: Sweep = None,
    settings: Settings = None,
    grid: Grid = None,
    zip: Zip = None,
    name: Name = None,
    write: Write = None,
    json: Json = False,
    **more: Any,
) -> int:
    """Compute and store the missing runs of an experiment.

    Two parameters without a file: hydrofdi sweep --grid EBM=551MPa:827MPa:3 --grid K_i=0,1e-8 --name mine

    Ctrl-C once finishes the runs in progress and stores them, twice stops at once; the same command resumes
    the sweep.
    """
    from hydrofdi.errors import SweepInterrupted

    try:
        results = hydrofdi.sweep(_asked(config, settings, grid, zip, name, write), progress=True, **more)
    except SweepInterrupted as stop:
        if stop.summary is not None:
            answer(stop.summary, json=json)
        raise
    assert results.summary is not None
    code, file = answer(results.summary, json=json), results.summary.file
    if more.get("part"):
        tell(f"stored part {more['part']}; 'hydrofdi collect {file.parent}' joins the parts")
    else:
        tell(f"stored {file}; see 'hydrofdi report {file.parent}'")
    return code


def _asked(
    config: Path | None,
    settings: list[str] | None,
    grid: list[str] | None,
    zipped: list[str] | None,
    name: str | None,
    write: Path | None,
) -> ExperimentConfig:
    """The experiment that a file and options describe."""
    stated = [f"name={name}"] * bool(name) + (settings or [])
    for kind, texts in (("grid", grid), ("zip", zipped)):
        names = [text.partition("=")[0] for text in texts or ()]
        for parameter, equals, axis in (text.partition("=") for text in texts or ()):
            if not axis or names.count(parameter) > 1:
                expected = "one NAME=AXIS for each parameter, such as EBM=551MPa:827MPa:3 or K_i=0,1e-8"
                raise ConfigError(f"--{kind} {parameter}: expected {expected}")
            is_yaml = axis.startswith(("[", "{")) or ":" in axis
            stated.append(f"sweep.{kind}.{parameter}{equals}{axis if is_yaml else f'[{axis}]'}")
    if not config and not stated:
        raise ConfigError("give an experiment file, or what varies: --grid EBM=551MPa:827MPa:3")
    if write is not None:
        from hydrofdi.config.loading import text_of_settings
        from hydrofdi.settings.files import write_new

        is_file = config is not None and config.exists()
        extends = os.path.relpath(str(config), write.parent) if is_file else str(config or "")
        write_new(write, text_of_settings(stated, extends))
        tell(f"wrote {write}")
        config, stated = write, []
    return hydrofdi.load_experiment(config, stated)


def plan(
    config: Sweep = None,
    settings: Settings = None,
    grid: Grid = None,
    zip: Zip = None,
    name: Name = None,
    **more: Any,
) -> Found:
    """Show what a sweep would do, why, and how long it takes.

    Writes nothing.
    """
    return hydrofdi.plan(_asked(config, settings, grid, zip, name, None), **more)


def status(directory: Directory) -> Found:
    """Show sweep progress and damaged shards.

    Exit code 1 if runs failed or a shard is damaged.
    """
    return hydrofdi.status(directory)


def collect(directory: Directory) -> Found:
    """Build the experiment file from the stored runs.

    Runs without a result are marked as missing, with the reason.
    """
    from hydrofdi.tables.answer import Reply

    made, state = hydrofdi.collect(directory), hydrofdi.status(directory)
    counts = {"planned": state.planned, "missing": state.missing, "failed": state.failed}
    told = f"{counted(state.planned, 'run')}, {state.missing:,} missing, {state.failed:,} failed"
    return Reply({"file": made.file, **counts}, told=(f"stored {made.file}: {told}",))


def calibrate(config: Config = None, settings: Settings = None, **more: Any) -> Found:
    """Compute the coefficients K_i of mean leakage flows.

    They are valid under the conditions of the baseline.
    """
    from hydrofdi.tables.answer import Reply

    targets = hydrofdi.calibrate(hydrofdi.load_experiment(config, settings or ()), **more)
    return Reply({"targets": targets}, [targets])


Run = Annotated[
    str, typer.Argument(metavar="RUN", help="First characters of a run's identity, or its position.")
]


def verify(directory: Directory) -> Found:
    """Check every shard of a folder against its checksum.

    Also checks the index and the experiment file. Exit code 1 if anything is wrong.
    """
    return hydrofdi.verify(directory)


def why(directory: Directory, run: Run) -> Found:
    """Explain a run: its settings and verdict.

    Also shows its differences from the baseline, its failure, and how it was computed.
    """
    return hydrofdi.why(directory, run)


def rerun(directory: Directory, run: Run, **settings: Any) -> Found:
    """Recompute a stored run and compare it bit for bit.

    Exit code 1 if the two results differ.
    """
    return hydrofdi.rerun(directory, run, **settings)


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
        Literal["text", "markdown", "latex", "csv", "wide", "json", "html"] | None,
        typer.Option(
            "--format",
            help="Format of the report [default: text]. latex: the answers, with booktabs. csv: a line for"
            " each run and level; wide: for each run. html writes a page, as --html does.",
        ),
    ] = None,
    html: Annotated[bool, typer.Option("--html", help="Write one self-contained HTML page.")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write the report and its figures to this folder.")
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="NAME.svg",
            help="Draw the figure of this name (.png, .svg, .pdf). Any sweep: responses,"
            " sensitivity (heat maps over two parameters). A study of detection: answer, ranking, pod, roc,"
            " false_alarms, densities, delays. With 'paper: maddahi2015': figure2, figure3, figure4,"
            " phases.",
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
    from hydrofdi.config.values import shown_in

    html = html or form == "html"
    directory, page = _places(places or [], html)
    results = hydrofdi.load(directory)
    with shown_in(results.data.experiment.units):
        made = results.composed
        if figure is not None:
            from hydrofdi.report.figures import write_figure

            tell(f"drew {figure}: {write_figure(made, figure)}")
        if html:
            from hydrofdi.report.page import write_page

            page = page or made.path.with_suffix(".html")
            write_page(made, page)
            tell(f"wrote {page}")
        if out is not None:
            from hydrofdi.report.page import write_all_forms

            lines = [*write_all_forms(made, out)]
            lost = [line for line in lines if not line.startswith("wrote ")]
            tell(f"wrote {counted(len(lines) - len(lost), 'file')} to {out}", *lost)
        if json or form not in (None, "html") or not (html or out or check or figure):
            _print(made, "json" if json else form or "text", full)
        return _check_code(made) if check else 0


def _places(places: list[Path], html: bool) -> tuple[Path | None, Path | None]:
    pages = [place for place in places if place.suffix.lower() == ".html"]
    folders = [place for place in places if place not in pages]
    if len(folders) > 1 or len(pages) > html:
        raise ReportError("give one folder, and after --html at most one page, whose name ends in .html")
    return next(iter(folders), None), next(iter(pages), None)


def _print(made: ComposedReport, form: str, full: bool) -> None:
    from hydrofdi.report.page import render_json, render_latex, render_markdown
    from hydrofdi.tables.answer import Reply
    from hydrofdi.tables.table import Table

    if form == "text":
        answer(Reply({}, _document(made, full)))
    elif form in ("markdown", "latex"):
        write_out((render_markdown if form == "markdown" else render_latex)(made.document()))
    elif form == "wide":
        write_out(Table.of(made.wide()).to_csv())
    else:
        write_out(Table.of(made.columns()).to_csv() if form == "csv" else render_json(made))


def _document(made: ComposedReport, full: bool) -> Iterator[Any]:
    """The answers of a report, or all of it; the answers are last."""
    from hydrofdi.tables.answer import Strong

    document = made.document()
    yield Strong(f"{document.title}, from {made.path}")
    blocks = [block for block in document.blocks if block.paragraphs or block.shown_tables]
    others = [block for block in blocks if not block.is_answer]
    for block in (others if full else []) + [block for block in blocks if block.is_answer]:
        if full:
            yield Strong(block.title)
        tables = [replace(table, most=None if full else _FEW_ROWS) for table in block.shown_tables]
        yield from ([*tables, *block.paragraphs] if block.is_answer else [*block.paragraphs, *tables])
    if not full and (n_table := sum(len(block.shown_tables) for block in others)):
        yield f"{counted(n_table, 'more table')}: --full shows them, --html writes a page."


def _check_code(made: ComposedReport) -> int:
    """0 if all claims that the experiment file lists hold, else 1."""
    checks = made.checks()
    if not checks:
        raise ReportError(
            "--check has nothing to check: list claims in the experiment file, for example claims: [C1, C2]"
        )
    tell(*checks)
    return 0 if all(checks.values()) else 1
