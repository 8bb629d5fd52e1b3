"""``hydrofdi sweep``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, Settings


def sweep(
    config: Annotated[Path, typer.Argument(help="Experiment file with the parameters to vary.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the results [default: results/<name>].")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes [default: the cores that hydrofdi may use].")
    ] = None,
    settings: Settings = None,
    json: Json = False,
) -> int:
    """Run all combinations of an experiment file and store them; what is stored already is not run again."""
    from dataclasses import asdict

    from hydrofdi.cli.rendering import print_json, progress_bar, tell
    from hydrofdi.config import load_experiment
    from hydrofdi.pipeline import experiment_directory, plan_sweep, run_sweep

    experiment = load_experiment(config, settings or ())
    plan = plan_sweep(experiment, experiment_directory(experiment, out))
    with progress_bar(len(plan.missing)) as advance:
        summary = run_sweep(plan, workers, advance)
    if json:
        print_json(asdict(summary) | {"file": str(summary.file)})
    tell(
        f"{summary.planned} runs: {summary.completed} computed, {summary.skipped} stored before,"
        f" {summary.failed} failed, in {summary.seconds:.1f} s"
    )
    tell(f"stored {summary.file}; see 'hydrofdi report {summary.file.parent}'")
    return 1 if summary.failed else 0
