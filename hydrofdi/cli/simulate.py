"""``hydrofdi simulate``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, Settings


class SecondOpinion(StrEnum):
    """Solvers of SciPy."""

    lsoda = "lsoda"
    radau = "radau"


def simulate(
    config: Annotated[
        Path | None, typer.Argument(help="Experiment file; without it, the nominal actuator of the paper.")
    ] = None,
    settings: Settings = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.h5", help="Store the run in this file.")] = None,
    figure: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Draw the signals (.png, .svg or .pdf).")
    ] = None,
    solver: Annotated[
        SecondOpinion | None,
        typer.Option("--solver", help="Integrate the same equations with SciPy instead: a second opinion."),
    ] = None,
    json: Json = False,
) -> int:
    """Simulate one actuator and print its features.

    A sweep in the file is left aside.
    """
    from hydrofdi.assessment import plan_warnings as plan_warnings
    from hydrofdi.cli.rendering import print_run, tell_doubtful_settings
    from hydrofdi.cli.terminal import print_json, tell
    from hydrofdi.config import load_experiment
    from hydrofdi.pipeline import simulate_nominal, write_single_run
    from hydrofdi.report.run_summary import run_record, summarize_run
    from hydrofdi.store.files import require_replaceable

    experiment = load_experiment(config, settings or ())
    tell_doubtful_settings(experiment, with_sweep=False)
    if out is not None:
        require_replaceable(out)
    single = simulate_nominal(experiment, None if solver is None else solver.value)
    summary = summarize_run(single.run, single.columns)
    if out is not None:
        write_single_run(out, experiment, single)
        tell(f"stored {out}")
    if figure is not None:
        from hydrofdi.report.figures import draw_signals, save_figure

        save_figure(draw_signals(single.columns, experiment.wavelet, summary.title), figure)
        tell(f"drew {figure}")
    for warning in plan_warnings(lambda *_: [single.run.request]):
        tell(f"warning: {warning}")
    if json:
        print_json(run_record(summary))
    else:
        print_run(summary)
    if summary.status != "ok":
        tell(f"the run failed: {summary.status}: {summary.message}")
        return 1
    if summary.verdict != "ok":
        tell(f"read its numbers with care: {summary.verdict} (see docs/physics.md)")
    return 0
