"""``hydrofdi plan``, ``sweep``, ``status``, ``collect`` and ``calibrate``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Config, Directory, Json, Settings, Sweep
from hydrofdi.cli.terminal import answer, facts, print_json, tell, write_out
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.api.sweep import SweepSummary


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
    from hydrofdi.api.experiments import experiment_of
    from hydrofdi.api.sweep import sweep as run_missing
    from hydrofdi.errors import SweepInterrupted

    if dry_run:
        of_plan = {name: more[name] for name in ("out", "workers", "retry_failed") if name in more}
        return plan(config, settings, json, **of_plan)
    try:
        results = run_missing(experiment_of(config, settings or ()), progress=True, **more)
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

    from hydrofdi.quality.doubts import doubt_lines, remedy
    from hydrofdi.settings.readable import shown_seconds

    if json:
        print_json({**asdict(summary), "file": str(summary.file)})
    measured = f" ({summary.measured:,} from stored signals)" if summary.measured else ""
    tell(
        f"{counted(summary.planned, 'run')}: {summary.completed:,}"
        f" computed{measured}, {summary.skipped:,} stored"
        f" before, {summary.failed:,} failed, in {shown_seconds(summary.seconds)}",
        *doubt_lines(summary.verdicts),
        *(
            f"{count:,} {status}: {remedy(status)}"
            for status, count in summary.statuses.items()
            if remedy(status)
        ),
        *(f"{label}: {fault}" for label, fault in summary.faults.items()),
    )


def plan(config: Sweep, settings: Settings = None, json: Json = False, **more: Any) -> int:
    """Show what 'hydrofdi sweep' would do, why, and how long it takes.

    Writes nothing.
    """
    from hydrofdi.api.experiments import experiment_of
    from hydrofdi.api.plan import plan as make_plan
    from hydrofdi.config.shown_values import shown_in

    experiment = experiment_of(config, settings or ())
    record = make_plan(experiment, **more).to_dict()
    if json:
        print_json(record)
    else:
        with shown_in(experiment.units):
            write_out("\n".join(facts(_facts(record), 13)) + "\n")
    return 0


def _facts(record: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What a plan says, line by line."""
    from hydrofdi.settings.readable import shown_bytes, shown_seconds

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
    least, most = (shown_seconds(record[f"predicted_seconds{end}"]) for end in ("", "_most"))
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
    if json:
        print_json(asdict(state))
    else:
        write_out(f"{state}\n")
        write_out("".join(f"{line}\n" for line in doubt_lines(state.verdicts)))
        if state.earlier:
            write_out(
                f"stored by an earlier version of the physics: {counted(state.earlier, 'run')};"
                " 'hydrofdi report' reads them, and a sweep computes them again\n"
            )
        write_out("".join(f"{fault}; the next sweep computes its runs again\n" for fault in state.damaged))
    return 1 if state.failed or state.damaged else 0


def collect(directory: Directory, json: Json = False) -> int:
    """Build the experiment file from the stored runs.

    Runs without a result are marked as missing, with the reason.
    """
    from hydrofdi.api.folders import collect as build_file
    from hydrofdi.api.folders import status as look

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
    from hydrofdi.api.experiments import experiment_of

    targets = solve(experiment_of(config, settings or ()), **more)
    record = {"targets": [asdict(target) for target in targets]}
    answer(record, lambda _: [targets_table(targets)], json=json)
    return 0
