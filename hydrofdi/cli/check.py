"""``hydrofdi check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, Settings


def check(
    config: Annotated[
        Path | None,
        typer.Argument(help="Experiment file, or a ready one; without it, the default actuator."),
    ] = None,
    settings: Settings = None,
    converge: Annotated[
        bool, typer.Option("--converge", help="Halve the step until no detail RMS changes any more.")
    ] = False,
    tolerance: Annotated[
        float, typer.Option(min=1e-9, help="Relative change of a detail RMS that --converge accepts.")
    ] = 1e-3,
    json: Json = False,
) -> int:
    """Inspect an experiment before running it.

    Shows step, hydraulic mode and bands, record, leakage, stroke and sensor noise, and how well a healthy
    record determines the unknowns of model-based indicators.

    Simulates up to 60 of the runs that differ in more than their sensors; step limits cover all runs.
    Exit code 1 if results would be wrong.
    """
    from hydrofdi.api.check import check as look
    from hydrofdi.api.experiments import experiment_with
    from hydrofdi.cli.assessment_rendering import print_convergence, print_inspection
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.config.shown_values import shown_in

    experiment = experiment_with(config, settings or ())
    found = look(experiment, halve_step=converge, tolerance=tolerance)
    if json:
        print_json(found.to_dict())
        return 0 if found else 1
    with shown_in(experiment.units):
        print_inspection(found)
    if found.convergence is not None:
        print_convergence(found.convergence)
    return 0 if found else 1
