"""``hydrofdi sweep``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, Settings


class EngineName(StrEnum):
    """Places where runs are computed."""

    local = "local"
    in_process = "in-process"
    dask = "dask"


def sweep(
    config: Annotated[
        Path, typer.Argument(help="Experiment file with what varies, or a ready one ('hydrofdi configs').")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the results [default: results/<name>].")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes [default: the cores that hydrofdi may use].")
    ] = None,
    settings: Settings = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Try runs again that raised, hung or lost their worker.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would be done, as 'hydrofdi plan' does.")
    ] = False,
    engine: Annotated[EngineName, typer.Option(help="Where the runs are computed.")] = EngineName.local,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler, e.g. tcp://host:8786.")
    ] = None,
    shared_directory: Annotated[
        bool,
        typer.Option(
            "--shared-directory/--no-shared-directory",
            help="Whether Dask workers reach the folder of the results; else they send their shards.",
        ),
    ] = True,
    json: Json = False,
) -> int:
    """Run whatever is missing and store it.

    Ctrl-C once finishes what runs and stores it, twice stops at once; the same command goes on later.
    """
    from dataclasses import asdict

    from hydrofdi.cli.plan import show_plan
    from hydrofdi.cli.rendering import tell_doubtful_settings
    from hydrofdi.cli.terminal import print_json, tell
    from hydrofdi.cli.watching import SweepWatcher
    from hydrofdi.config import load_experiment
    from hydrofdi.pipeline import experiment_directory, run_sweep
    from hydrofdi.pipeline.engines import make_engine

    experiment = load_experiment(config, settings or ())
    directory = experiment_directory(experiment, out)
    if dry_run:
        return show_plan(experiment, directory, workers, retry_failed=retry_failed, json=json)
    tell_doubtful_settings(experiment, with_study=True)
    chosen = make_engine(engine.value, workers, scheduler, shared_directory=shared_directory)
    with SweepWatcher() as watcher:
        summary = run_sweep(experiment, directory, chosen, watcher, retry_failed=retry_failed)
    if json:
        print_json({**asdict(summary), "file": str(summary.file)})
    measured = f" ({summary.measured} from stored signals)" if summary.measured else ""
    tell(
        f"{summary.planned} runs: {summary.completed} computed{measured}, {summary.skipped} stored before,"
        f" {summary.failed} failed, in {summary.seconds:.1f} s"
    )
    for label, fault in summary.faults.items():
        tell(f"{label}: {fault}")
    if summary.interrupted:
        tell("interrupted; the same command goes on where this one ended")
        return 130
    tell(f"stored {summary.file}; see 'hydrofdi report {summary.file.parent}'")
    return 1 if summary.failed or summary.faults else 0
