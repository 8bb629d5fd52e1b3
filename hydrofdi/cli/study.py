"""``hydrofdi plan``, ``sweep``, ``status``, ``collect``, ``calibrate``, ``report``, and the audit of runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from hydrofdi.cli.options import Config, Directory, Json, Settings, Sweep
from hydrofdi.cli.terminal import answer, facts, print_json, tell, write_out
from hydrofdi.errors import ReportError
from hydrofdi.settings.messages import counted

if TYPE_CHECKING:
    from hydrofdi.api.folders import Explanation
    from hydrofdi.api.results import SweepSummary
    from hydrofdi.report.table import ComposedReport, Table


def sweep(
    config: Sweep,
    settings: Settings = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would be done, like 'hydrofdi plan'.")
    ] = False,
    json: Json = False,
    **more: Any,
) -> int:
    """Compute and store the missing runs of an experiment.

    Ctrl-C once finishes the runs in progress and stores them, twice stops at once; the same command resumes
    the sweep.
    """
    from hydrofdi.api.sweep import sweep as run_missing
    from hydrofdi.config import load_experiment
    from hydrofdi.errors import SweepInterrupted

    if dry_run:
        of_plan = {name: more[name] for name in ("out", "workers", "retry_failed") if name in more}
        return plan(config, settings, json, **of_plan)
    try:
        results = run_missing(load_experiment(config, settings or ()), progress=True, **more)
    except SweepInterrupted as stop:
        if stop.summary is not None:
            _show(stop.summary, json=json)
        raise
    assert results.summary is not None
    _show(results.summary, json=json)
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
    tell(
        f"{counted(summary.planned, 'run')}: {summary.completed:,}"
        f" computed{measured}, {summary.skipped:,} stored"
        f" before, {summary.failed:,} failed, in {time_text(summary.seconds)}",
        *doubt_lines(summary.verdicts),
        *(
            f"{count:,} {status}: {REMEDIES[status]}"
            for status, count in summary.statuses.items()
            if status in REMEDIES
        ),
        *(f"{label}: {fault}" for label, fault in summary.faults.items()),
    )


def plan(config: Sweep, settings: Settings = None, json: Json = False, **more: Any) -> int:
    """Show what 'hydrofdi sweep' would do, why, and how long it takes.

    Writes nothing.
    """
    from hydrofdi.api.plan import plan as make_plan
    from hydrofdi.config import load_experiment
    from hydrofdi.config.shown_values import shown_in

    experiment = load_experiment(config, settings or ())
    record = make_plan(experiment, **more).to_dict()
    with shown_in(experiment.units):
        answer(record, "\n".join(facts(_facts(record), 13)), json=json)
    return 0


def _facts(record: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What a plan says, line by line."""
    from hydrofdi.settings.readable import shown_bytes, time_text

    yield "experiment", f"{record['experiment']} → {record['file']}"
    yield from _study_facts(record["study"]) if record["study"] else _run_facts(record)
    yield "stored", f"{record['stored']:,}"
    if record["failed_before"]:
        yield "failed", f"{record['failed_before']:,} before; --retry-failed tries them again"
    simulated, measured = record["simulated_records"], record["measured_analyses"]
    shared = f": {counted(simulated, 'record')} to simulate" if simulated != record["missing"] else ""
    stored = f", {measured:,} to measure from stored signals" if measured else ""
    yield "to compute", f"{record['missing']:,}{shared}{stored}"
    for reason, count in record["reasons"].items():
        yield "  because", f"{reason}: {count:,}"
    flows, conditions, total = record["solutions"].values()
    if total:
        of = f"{counted(flows, 'leakage flow')} × {counted(conditions, 'condition')} = "
        once = "; 'calibration: {at: nominal}' solves each flow once"
        is_repeated = record["calibrated_at"] == "run" and conditions > 1
        text = f"{of if flows * conditions == total else ''}{counted(total, 'solution')}"
        yield "K_i", f"{text}{once if is_repeated else ''}"
    least, most = (time_text(record[f"predicted_seconds{end}"]) for end in ("", "_most"))
    size, free = (shown_bytes(record[f"{name}_bytes"]) for name in ("predicted_file", "free"))
    workers = counted(record["workers"], "worker")
    yield "predicted", f"{least} to {most} with {workers}, {size} (and as much in shards); {free} free"
    yield from (("warning", warning) for warning in record["warnings"])


def _run_facts(record: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What varies in a sweep, and its first and last points."""
    from hydrofdi.config.shown_values import shown_parameter, shown_values

    added = f"{record['controls_added']:,} healthy ones added for comparison"
    yield "runs", f"{record['planned']:,}: {record['swept']:,} of the sweep, {added}"
    for name, values in record["axes"].items():
        shown, header, spread = shown_parameter(name, values), name, ""
        if values and all(isinstance(value, float) for value in values):
            header, spread = shown.header, f" from {shown.text(min(values))} to {shown.text(max(values))}"
        yield "  axis", f"{header}: {counted(len(values), 'value')}{spread}"
    if record["axes"]:
        for end in ("first", "last"):
            yield f"{end} point", shown_values(record[f"{end}_point"]) or "nominal"


_PURPOSES = {"alone": "to explain", "before": "to compare with"}
"""Kind of a population that is not tested → its purpose."""


_MOST_DESIGNS = 12
"""Most designs that have a line each."""


def _study_facts(study: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The populations and designs of a study, and what varies."""
    from hydrofdi.config.shown_values import shown_value

    designs, n_record = study["designs"], study["records"]
    several = f": {n_record:,} in each of {len(designs)} designs" if len(designs) > 1 else ""
    yield "runs", f"{counted(n_record * len(designs), 'record')}{several}"
    alike: dict[tuple[str, str], list[str]] = {}
    for each in study["populations"]:
        purpose = "to fit" if each["is_fit"] else _PURPOSES.get(each["kind"], "to test")
        sets = f" ({_settings(each['sets'])})" if each["sets"] else ""
        alike.setdefault((each["kind"], f"{sets}: {each['records']:,} {purpose}"), []).append(each["name"])
    for (kind, told), names in alike.items():
        of = f"{len(names)} populations" if kind == "alone" else ", ".join(names)
        yield f"  {kind}", f"{of}{told}{' each' if len(names) > 1 else ''}".removeprefix(f"{kind}: ")
    if len(designs) > 1:
        yield from (("  design", _settings(design) or "nominal") for design in designs[:_MOST_DESIGNS])
        if len(designs) > _MOST_DESIGNS:
            yield "", f"and {len(designs) - _MOST_DESIGNS} more"
    for name, own in study["varies"].items():
        yield "  varies", f"{name}  {shown_value(name, own)}"
    yield "  per record", ", ".join(study["differs_per_record"]) or "nothing"


def _settings(values: Mapping[str, Any]) -> str:
    from hydrofdi.config.shown_values import shown_value

    return ", ".join(f"{name} {shown_value(name, value)}" for name, value in values.items())


def status(directory: Directory, json: Json = False) -> int:
    """Show sweep progress and damaged shards.

    Exit code 1 if runs failed or a shard is damaged.
    """
    from dataclasses import asdict

    from hydrofdi.api.folders import status as look
    from hydrofdi.quality.doubts import doubt_lines

    state = look(directory)
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
    from hydrofdi.api.folders import status as look
    from hydrofdi.api.sweep import collect as build_file

    made, state = build_file(directory), look(directory)
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
    from dataclasses import asdict

    from hydrofdi.api.check import calibrate as solve
    from hydrofdi.api.check import targets_table
    from hydrofdi.config import load_experiment

    targets = solve(load_experiment(config, settings or ()), **more)
    record = {"targets": [asdict(target) for target in targets]}
    answer(record, lambda _: [targets_table(targets)], json=json)
    return 0


Run = Annotated[
    str, typer.Argument(metavar="RUN", help="First characters of a run's identity, or its position.")
]


def verify(directory: Directory, json: Json = False) -> int:
    """Check every shard of a folder against its checksum.

    Also checks the index and the experiment file. Exit code 1 if anything is wrong.
    """
    from hydrofdi.api.folders import verify as find_faults

    found = find_faults(directory)
    record = {"sound": bool(found), "faults": found.faults}
    answer(record, "\n".join(found.faults or [str(found)]), json=json)
    return 0 if found else 1


def why(directory: Directory, run: Run, json: Json = False, **settings: Any) -> int:
    """Explain a run: its settings, verdict and what changed.

    Also shows its differences from the baseline, its failure, and how it was computed.
    """
    from hydrofdi.api.folders import why as explain
    from hydrofdi.config.shown_values import shown_in

    explanation = explain(directory, run, **settings)
    with shown_in(explanation.units):
        answer(vars(explanation), lambda _: _explanation(explanation), json=json)
    return 0


def _explanation(run: Explanation) -> Iterator[Any]:
    """The request of a run, its result, and what changed since."""
    from rich.text import Text

    from hydrofdi.config.shown_values import shown_value

    yield Text(f"run {run.run_id}, row {run.position}, record {run.record_id}", "bold")
    yield from facts([
        ("status", f"{run.status} {run.message}".rstrip()),
        ("remedy", run.remedy),
        ("verdict", run.verdict if run.verdict != run.status else ""),
        *(("", f"{word}: {told['meaning']}; {told['remedy']}") for word, told in run.doubts.items()),
        ("to do", run.reason),
        *(("because", cause) for cause in run.causes),
    ])  # fmt: skip
    if run.changes:
        yield _pairs("changed since runs were stored", ("key", "before", "now"), run.changes)
    yield f"stored in {run.shard or 'nothing'}"
    for label, analysis in run.analysis.items():
        yield f"analysis  {label} {analysis['analysis_id']}: {analysis['shown'] or 'default options'}"
    if run.differences:
        heads = ("parameter", "baseline", "run")
        yield _pairs("differs from the fixed baseline in", heads, run.differences)
    elif run.is_baseline:
        yield "This run is the fixed baseline."
    else:
        yield "This run has the same parameters as the baseline."
    if run.calibration:
        modulus = shown_value("fluid.bulk_modulus", run.calibration["fluid"]["bulk_modulus"])
        yield f"K_i was computed at an EBM of {modulus}, under the other baseline conditions"
    if made := run.provenance:
        from hydrofdi.config.plausibility import shown_seeds

        git, seeds = made["git"] or {"commit": "unknown", "dirty": False}, made["seeds"]
        shown = shown_seeds(seeds) if isinstance(seeds, dict) else ", ".join(map(str, seeds)) or "none"
        yield f"swept {made['started']} by: {' '.join(made['command'])}"
        yield f"commit {git['commit']}{' with changes' if git['dirty'] else ''}, Python {made['python']}"
        yield f"seeds     {shown}"
    if run.log:
        yield run.log


def _pairs(title: str, headers: tuple[str, str, str], pairs: Mapping[str, tuple[Any, Any]]) -> Table:
    """A table of names, each with two values in readable units."""
    from hydrofdi.report.table import Table

    values = ([_shown(name, both[place]) for name, both in pairs.items()] for place in (0, 1))
    return Table.of(dict(zip(headers, ([*pairs], *values), strict=True)), title=title)


def _shown(name: str, value: Any) -> str:
    """A value, or the values of an axis, such as ``sweep.grid: fluid.bulk_modulus``."""
    from json import dumps

    from hydrofdi.config.request import parameter_names
    from hydrofdi.config.shown_values import shown_value
    from hydrofdi.settings.readable import HOLE

    parameter = name.rpartition(": ")[2]
    if value is None:
        return HOLE
    if parameter not in set(parameter_names()):
        return value if isinstance(value, str) else dumps(value)
    return ", ".join(shown_value(parameter, each) for each in (value if isinstance(value, list) else [value]))


def rerun(directory: Directory, run: Run, json: Json = False) -> int:
    """Recompute a stored run and compare it bit for bit.

    Exit code 1 if the two results differ.
    """
    from hydrofdi.api.folders import rerun as compute_again

    found = compute_again(directory, run)
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
