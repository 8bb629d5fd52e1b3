"""``hydrofdi calibrate``."""

from __future__ import annotations

from typing import Annotated

import typer

from hydrofdi.cli.options import Config, Json, Settings


def calibrate(
    config: Config = None,
    flows: Annotated[
        list[str] | None,
        typer.Option("--flow", metavar="FLOW", help="Mean leakage flow, e.g. '0.12 L/min'. Repeatable."),
    ] = None,
    settings: Settings = None,
    json: Json = False,
) -> int:
    """Compute the coefficients K_i of mean leakage flows.

    They are valid under the conditions of the baseline.
    """
    from dataclasses import asdict

    from hydrofdi.api.check import calibrate as solve
    from hydrofdi.api.check import refuse_flow
    from hydrofdi.api.check_tables import targets_table
    from hydrofdi.api.experiments import experiment_with
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import print_json, terminal

    refuse_flow(config)
    targets = solve(experiment_with(config, settings or ()), flows=flows or ())
    if json:
        print_json({"targets": [asdict(target) for target in targets]})
    else:
        print_table(terminal(), targets_table(targets))
    return 0
