"""``hydrofdi calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, Settings


def calibrate(
    config: Annotated[
        Path | None,
        typer.Argument(
            help="Experiment file, or a ready one; without it, the nominal actuator of the paper."
        ),
    ] = None,
    flows: Annotated[
        list[str] | None,
        typer.Option("--flow", metavar="FLOW", help="Mean leakage flow, e.g. '0.12 L/min'. Repeatable."),
    ] = None,
    settings: Settings = None,
    json: Json = False,
) -> int:
    """Solve mean leakage flows for their coefficients.

    Under the conditions of the baseline.
    """
    from dataclasses import asdict

    from hydrofdi.assessment import calibrate_flows
    from hydrofdi.cli.assessment_rendering import print_targets
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.config import load_experiment

    targets = calibrate_flows(load_experiment(config, settings or ()), _parsed(flows or ()))
    if json:
        print_json({"targets": [asdict(target) for target in targets]})
    else:
        print_targets(targets)
    return 0


def _parsed(flows: list[str] | tuple[()]) -> list[float]:
    from hydrofdi.errors import ConfigError, Mistake
    from hydrofdi.units import parse_quantity

    values, mistakes = [], []
    for text in flows:
        try:
            values.append(parse_quantity(text, "m^3/s"))
            if not values[-1] > 0.0:
                mistakes.append(Mistake("must be above zero", origin=f"--flow {text}"))
        except ValueError as error:
            mistakes.append(Mistake(str(error), origin=f"--flow {text}"))
    if not flows:
        mistakes.append(Mistake("name at least one flow, e.g. --flow '0.12 L/min'"))
    if mistakes:
        raise ConfigError(mistakes)
    return values
