"""``hydrofdi check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, Settings


def check(
    config: Annotated[
        Path | None,
        typer.Argument(
            help="Experiment file, or a ready one; without it, the nominal actuator of the paper."
        ),
    ] = None,
    settings: Settings = None,
    converge: Annotated[
        bool, typer.Option("--converge", help="Halve the step until the detail RMS stand still.")
    ] = False,
    tolerance: Annotated[
        float, typer.Option(min=1e-9, help="Relative change of a detail RMS that --converge accepts.")
    ] = 1e-3,
    json: Json = False,
) -> int:
    """Look at an experiment before running it.

    Step, hydraulic mode and bands, record, leakage, stroke, sensor noise; what a healthy record tells of the
    unknowns of model-based indicators.

    All runs that differ in more than their sensors are simulated, up to 60; step limits are those of all
    runs. Exit code 1 where results would be wrong.
    """
    from hydrofdi.assessment import converge as halve_step
    from hydrofdi.assessment import inspect_experiment
    from hydrofdi.assessment.selection import select_runs
    from hydrofdi.cli.assessment_rendering import inspection_record, print_convergence, print_inspection
    from hydrofdi.cli.rendering import tell_doubtful_settings
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.config import load_experiment

    experiment = load_experiment(config, settings or ())
    tell_doubtful_settings(experiment, with_study=True)
    selection = select_runs(experiment)
    inspection = inspect_experiment(selection)
    convergence = halve_step(selection.jobs, tolerance) if converge else None
    if json:
        print_json(inspection_record(inspection, convergence))
    else:
        print_inspection(inspection)
        if convergence is not None:
            print_convergence(convergence)
    unconverged = convergence is not None and convergence.good_enough is None
    return 1 if inspection.problems or unconverged else 0
