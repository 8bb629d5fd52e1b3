"""``hydrofdi simulate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Config, Figure, Json, Settings

if TYPE_CHECKING:
    from hydrofdi.config import ExperimentConfig


def simulate(
    config: Config = None,
    settings: Settings = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Store the run in this file.")] = None,
    figure: Figure = None,
    json: Json = False,
) -> int:
    """Simulate one actuator and print its features.

    Ignores a sweep in the file.
    """
    from hydrofdi.api.experiments import experiment_with
    from hydrofdi.config.shown_values import shown_in

    experiment = experiment_with(config, settings or ())
    with shown_in(experiment.units):
        return _simulate(experiment, out, figure, json=json)


def _simulate(
    experiment: ExperimentConfig,
    out: Path | None,
    figure: Path | None,
    *,
    json: bool,
) -> int:
    from hydrofdi.api.run import simulate as simulate_actuator
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import print_json, tell, terminal
    from hydrofdi.quality.doubts import doubts_of, remedy

    run = simulate_actuator(experiment, out=out)
    if out is not None:
        tell(f"stored {out}")
    if figure is not None:
        from hydrofdi.report.figures import save_figure

        save_figure(run.plot(), figure)
        tell(f"drew {figure}")
    for warning in run.warnings:
        tell(f"warning: {warning}")
    if json:
        print_json(run.to_dict())
    else:
        print_table(terminal(), run.table)
    if run.status != "ok":
        tell(f"the run failed: {run.status}: {run.message}; {remedy(run.status)}")
        return 1
    for doubt in doubts_of(run.verdict):
        tell(f"{doubt.word}: {doubt.remedy}")
    return 0
