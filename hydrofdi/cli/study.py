"""``hydrofdi plan``, ``sweep``, ``status``, ``collect``, ``calibrate``, ``report``, and the audit of runs."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import hydrofdi
from hydrofdi.cli.options import Config, Directory, Grid, Json, Name, Settings, Sweep, Write, Zip
from hydrofdi.cli.terminal import answer, facts, print_json, tell, write_out
from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.settings.messages import counted

if TYPE_CHECKING:
    from hydrofdi.api.folders import Explanation
    from hydrofdi.api.plan import Plan
    from hydrofdi.api.results import SweepSummary
    from hydrofdi.config import ExperimentConfig
    from hydrofdi.report.table import ComposedReport


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
            _show(stop.summary, json=json)
        raise
    assert results.summary is not None
    _show(results.summary, json=json)
    if more.get("part"):
        folder = results.summary.file.parent
        tell(f"stored part {more['part']}; 'hydrofdi collect {folder}' joins the parts")
    else:
        tell(f"stored {results.file}; see 'hydrofdi report {results.folder}'")
    return 1 if results.summary.failed or results.summary.faults else 0


def _show(summary: SweepSummary, *, json: bool) -> None:
    """Print what a sweep did, and the verdicts on its runs."""
    from dataclasses import asdict

    from hydrofdi.quality.doubts import REMEDIES, doubt_lines
    from hydrofdi.settings.readable import time_text

    if json:
        print_json({**asdict(summary), "file": str(summary.file)})
    measured = f" ({summary.measured:,} from stored signals)" if summary.measured else ""
    lost = f", {counted(summary.lost_workers, 'worker')} lost and replaced" * bool(summary.lost_workers)
    tell(
        f"{counted(summary.planned, 'run')}: {summary.completed:,}"
        f" computed{measured}, {summary.skipped:,} stored"
        f" before, {summary.failed:,} failed, in {time_text(summary.seconds)}{lost}",
        *doubt_lines(summary.verdicts),
        *(
            f"{count:,} {status}: {REMEDIES[status]}"
            for status, count in summary.statuses.items()
            if status in REMEDIES
        ),
        *(f"{label}: {fault}" for label, fault in summary.faults.items()),
    )


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

        is_file = config is not None and config.exists()
        extends = os.path.relpath(str(config), write.parent) if is_file else str(config or "")
        text = text_of_settings(stated, extends)
        try:
            with write.open("x", encoding="utf-8") as new:
                new.write(text)
        except OSError as error:
            raise ConfigError(f"{write}: {error.strerror}") from None
        tell(f"wrote {write}")
        config, stated = write, []
    return hydrofdi.load_experiment(config, stated)


def plan(
    config: Sweep = None,
    settings: Settings = None,
    grid: Grid = None,
    zip: Zip = None,
    name: Name = None,
    json: Json = False,
    **more: Any,
) -> int:
    """Show what a sweep would do, why, and how long it takes.

    Writes nothing.
    """
    from hydrofdi.config.shown_values import shown_in

    experiment = _asked(config, settings, grid, zip, name, None)
    with shown_in(experiment.units):
        answer(hydrofdi.plan(experiment, **more), _plan, json=json)
    return 0


def _plan(made: Plan) -> Iterator[Any]:
    """What a plan says; records of a study of one kind and purpose have a row."""
    from hydrofdi.config.shown_values import shown_values
    from hydrofdi.report.table import Table
    from hydrofdi.settings.readable import shown_bytes, time_text

    study, added, failed = made.study or {}, made.controls_added, made.failed_before
    reasons = ", ".join(f"{reason} {count:,}" for reason, count in made.reasons.items())
    size, free = map(shown_bytes, (made.predicted_file_bytes, made.free_bytes))
    times = " to ".join(map(time_text, (made.predicted_seconds, made.predicted_seconds_most)))
    yield from facts(
        {
            "experiment": f"{made.experiment} → {made.file}",
            "runs": f"{made.planned:,}" + f", {added:,} of them healthy for comparison" * bool(added),
            "axes": made.axes,
            "first point": shown_values(made.first_point),
            "last point": shown_values(made.last_point),
            "designs": study["designs"] if study and len(study["designs"]) > 1 else [],
            "varies": study.get("varies"),
            "per record": ", ".join(study.get("differs_per_record", ())),
            "stored": made.stored,
            "failed": f"{failed:,} before; --retry-failed tries them again" * bool(failed),
            "to compute": f"{made.missing:,}" + (f" ({reasons})" if reasons else ""),
            "to simulate": counted(made.simulated_records, "record"),
            "leakage coefficients": counted(made.solutions["total"], "solution"),
            "predicted": f"{times} with {counted(made.workers, 'worker')}" * bool(made.missing),
            "size": f"{size}, and as much in shards; {free} free",
        }
    )
    if study:
        alike: dict[tuple[str, str], list[dict[str, Any]]] = {}
        for each in study["populations"]:
            alike.setdefault((each["kind"], "fit" if each["is_fit"] else "test"), []).append(each)
        columns = {
            "records of": [kind for kind, _ in alike],
            "to": [purpose for _, purpose in alike],
            "number": [sum(each["records"] for each in own) for own in alike.values()],
            "populations": [", ".join(each["name"] for each in own) for own in alike.values()],
        }
        yield from ("", Table.of(columns), "")
    yield from (f"warning: {warning}" for warning in made.warnings)


def status(directory: Directory, json: Json = False) -> int:
    """Show sweep progress and damaged shards.

    Exit code 1 if runs failed or a shard is damaged.
    """
    from dataclasses import asdict

    from hydrofdi.quality.doubts import doubt_lines

    state = hydrofdi.status(directory)
    lines = [str(state), *doubt_lines(state.verdicts)]
    if state.earlier:
        runs = counted(state.earlier, "run")
        lines.append(f"stored by an earlier version of the physics: {runs}; a sweep computes them again")
    lines += [f"{fault}; the next sweep computes its runs again" for fault in state.damaged]
    answer(asdict(state), "\n".join(lines), json=json)
    return 1 if state.failed or state.damaged else 0


def collect(directory: Directory, json: Json = False) -> int:
    """Build the experiment file from the stored runs.

    Runs without a result are marked as missing, with the reason.
    """
    made, state = hydrofdi.collect(directory), hydrofdi.status(directory)
    if json:
        record = {"planned": state.planned, "missing": state.missing, "failed": state.failed}
        print_json({"file": str(made.file), **record})
    tell(
        f"stored {made.file}: {counted(state.planned, 'run')}, {state.missing:,}"
        f" missing, {state.failed:,} failed"
    )
    return 0


def calibrate(config: Config = None, settings: Settings = None, json: Json = False, **more: Any) -> int:
    """Compute the coefficients K_i of mean leakage flows.

    They are valid under the conditions of the baseline.
    """
    targets = hydrofdi.calibrate(hydrofdi.load_experiment(config, settings or ()), **more)
    answer({"targets": [*targets]}, lambda _: [targets], json=json)
    return 0


Run = Annotated[
    str, typer.Argument(metavar="RUN", help="First characters of a run's identity, or its position.")
]


def verify(directory: Directory, json: Json = False) -> int:
    """Check every shard of a folder against its checksum.

    Also checks the index and the experiment file. Exit code 1 if anything is wrong.
    """
    found = hydrofdi.verify(directory)
    record = {"sound": bool(found), "faults": found.faults}
    answer(record, "\n".join(found.faults or [str(found)]), json=json)
    return 0 if found else 1


def why(directory: Directory, run: Run, json: Json = False, **settings: Any) -> int:
    """Explain a run: its settings, verdict and what changed.

    Also shows its differences from the baseline, its failure, and how it was computed.
    """
    from hydrofdi.config.shown_values import shown_in

    explanation = hydrofdi.why(directory, run, **settings)
    with shown_in(explanation.units):
        answer(vars(explanation), lambda _: _explanation(explanation), json=json)
    return 0


def _explanation(run: Explanation) -> Iterator[Any]:
    """What is known of a run, without its whole request."""
    told = dict(vars(run))
    for name in ("request", "calibration", "units", "log", "provenance"):
        del told[name]
    told["analysis"] = {
        label: f"{each['analysis_id']}: {each['shown'] or 'default options'}"
        for label, each in run.analysis.items()
    }
    if run.provenance:
        told |= {name: run.provenance[name] for name in ("started", "python", "seeds")}
        git = run.provenance["git"] or {}
        told["commit"] = f"{git.get('commit') or ''}{', with changes' * bool(git.get('dirty'))}"
        told["command"] = " ".join(run.provenance["command"])
    yield from facts(told)
    if run.log:
        yield run.log


def rerun(directory: Directory, run: Run, json: Json = False, **settings: Any) -> int:
    """Recompute a stored run and compare it bit for bit.

    Exit code 1 if the two results differ.
    """
    found = hydrofdi.rerun(directory, run, **settings)
    record = {"run_id": found.run_id, "same_bits": bool(found), "differing": found.differing}
    answer(record, str(found), json=json)
    return 0 if found else 1


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
            " sensitivity (heat maps over two parameters). A study of detection: answer, ranking, pod, roc,"
            " det, false_alarms, densities, delays. With 'paper: maddahi2015': figure2, figure3, figure4,"
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
    from hydrofdi.config.shown_values import shown_in

    html = html or form == "html"
    directory, page = _places(places or [], html)
    results = hydrofdi.load(directory)
    with shown_in(results.data.experiment.units):
        made = results.composed
        if figure is not None:
            from hydrofdi.report.figures import KINDS, write_figure

            target = out if out and out.suffix[1:] in KINDS else figure if figure.suffix else out
            if target is None:
                raise ReportError(f"--figure {figure}: add --out FILE, or write --figure {figure}.svg")
            tell(f"drew {target}: {write_figure(made, target, figure.stem)}")
            out = None if target == out else out
        if html:
            from hydrofdi.report.forms.page import write_page

            page = page or made.path.with_suffix(".html")
            write_page(made, page)
            tell(f"wrote {page}")
        if out is not None:
            from hydrofdi.report.forms.page import write_all_forms

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
    from hydrofdi.cli.tables import print_document
    from hydrofdi.report.forms.page import render_json, render_latex, render_markdown
    from hydrofdi.report.table import Table

    if form == "text":
        print_document(made.document(), made.path, full=full)
    elif form in ("markdown", "latex"):
        write_out((render_markdown if form == "markdown" else render_latex)(made.document()))
    elif form == "wide":
        write_out(Table.of(made.wide()).to_csv())
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
