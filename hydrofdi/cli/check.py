"""``hydrofdi check``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Config, Json, Settings
from hydrofdi.settings.counting import counted
from hydrofdi.units import convert

if TYPE_CHECKING:
    from rich.console import Console

    from hydrofdi.api.check import Check
    from hydrofdi.api.inspection import Observability


def check(
    config: Config = None,
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
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.config.shown_values import shown_in

    experiment = experiment_with(config, settings or ())
    found = look(experiment, halve_step=converge, tolerance=tolerance)
    if json:
        print_json(found.to_dict())
        return 0 if found else 1
    with shown_in(experiment.units):
        _print(found)
    return 0 if found else 1


def _print(check: Check) -> None:
    """Print step, modes, record, noise, what a record tells estimators, and warnings."""
    from rich.text import Text

    from hydrofdi.api.check_tables import convergence_table, modes_table, noise_table
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal

    console, found = terminal(), check.inspection
    limits = ", ".join(
        f"{part} {convert(limit, 'ms'):.3g}"
        for part, limit in sorted(found.step_limits.items(), key=lambda item: item[1])
    )
    console.print(Text("Step", style="bold"))
    console.print(
        f"{convert(found.step, 'ms'):g} ms, limited by {found.binding}; stable up to [ms]: {limits}\n"
    )
    console.print(Text("Hydraulic mode", style="bold"))
    print_table(console, modes_table(found))
    if found.n_left_out:
        console.print(f"left out: {counted(found.n_left_out, 'further run')}")
    console.print(Text("\nRecord", style="bold"))
    shares = ", ".join(f"d{level} {share:.1%}" for level, share in enumerate(found.boundary_shares, 1))
    periods = f", {counted(found.n_period, 'period')}" if math.isfinite(found.n_period) else ""
    console.print(f"{counted(found.n_sample, 'sample')}{periods}; coefficients at its ends: {shares}\n")
    if found.noise:
        print_table(console, noise_table(found))
        console.print()
    for estimator in found.observability:
        _print_observability(console, estimator)
        console.print()
    for problem in found.problems:
        console.print(Text(f"problem: {problem}", style="bold red"))
    for warning in check.warnings:
        console.print(f"warning: {warning}", soft_wrap=True)
    if not found.problems and not check.warnings:
        console.print("no warnings")
    if check.convergence is not None:
        console.print()
        print_table(console, convergence_table(check.convergence))


def _print_observability(console: Console, found: Observability) -> None:
    """Print each unknown before and after a record, the least known direction, and collinear pairs."""
    from hydrofdi.api.check_tables import unknowns_table
    from hydrofdi.cli.tables import print_table

    print_table(console, unknowns_table(found))
    if not found.unknowns:
        console.print("nothing: the estimate diverges; do its options fit the actuator?")
    elif not any(found.singular_values):
        console.print("the record contains no information on them; does the valve open?")
    else:
        condition = f"{found.condition:.2g}" if math.isfinite(found.condition) else "infinite"
        left = f"{found.weakest_left:.0%} of the prior deviation remains"
        console.print(f"condition number {condition}; least known: {found.weakest}: {left}")
        pairs = ", ".join(f"{one} and {other} ({value:+.3f})" for one, other, value in found.collinear)
        console.print(f"collinear: {pairs or 'none'}")
