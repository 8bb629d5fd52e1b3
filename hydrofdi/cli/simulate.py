"""``hydrofdi simulate``."""

from __future__ import annotations

from typing import Any

from hydrofdi.cli.options import Config, Figure, Json, Settings
from hydrofdi.cli.terminal import answer, draw, tell


def simulate(
    config: Config = None, settings: Settings = None, figure: Figure = None, json: Json = False, **more: Any
) -> int:
    """Simulate one actuator and print its features.

    Ignores a sweep in the file.
    """
    from hydrofdi.api.experiments import experiment_with
    from hydrofdi.api.run import simulate as simulate_actuator
    from hydrofdi.config.shown_values import shown_in
    from hydrofdi.quality.doubts import doubts_of, remedy

    experiment = experiment_with(config, settings or ())
    with shown_in(experiment.units):
        run = simulate_actuator(experiment, **more)
        if more:
            tell(f"stored {more['out']}")
        draw(run, figure)
        for warning in run.warnings:
            tell(f"warning: {warning}")
        answer(run, lambda run: [run.table], json=json)
        if run.status != "ok":
            tell(f"the run failed: {run.status}: {run.message}; {remedy(run.status)}")
            return 1
        for doubt in doubts_of(run.verdict):
            tell(f"{doubt.word}: {doubt.remedy}")
        return 0
