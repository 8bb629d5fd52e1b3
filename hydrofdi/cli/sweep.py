"""``hydrofdi sweep``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, Results, Settings, Sweep, Workers
from hydrofdi.cli.terminal import print_json, tell
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.api.sweep import SweepSummary


def sweep(
    config: Sweep,
    out: Results = None,
    workers: Workers = None,
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
    from hydrofdi.api.experiments import experiment_with
    from hydrofdi.api.sweep import sweep as run_missing
    from hydrofdi.cli.plan import show_plan
    from hydrofdi.errors import SweepInterrupted

    experiment = experiment_with(config, settings or ())
    if dry_run:
        return show_plan(experiment, out, workers, retry_failed=more.get("retry_failed", False), json=json)
    try:
        results = run_missing(experiment, out=out, workers=workers, progress=True, **more)
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
        f" before, {summary.failed:,} failed, in {shown_seconds(summary.seconds)}"
    )
    for line in doubt_lines(summary.verdicts):
        tell(line)
    for status, count in summary.statuses.items():
        if told := remedy(status):
            tell(f"{count:,} {status}: {told}")
    for label, fault in summary.faults.items():
        tell(f"{label}: {fault}")
