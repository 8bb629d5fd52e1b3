"""``hydrofdi check`` and ``hydrofdi calibrate``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from hydrofdi.cli.options import Config, Json, Settings
from hydrofdi.cli.terminal import answer
from hydrofdi.settings.counting import counted
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.check import Check
    from hydrofdi.api.inspection import Observability


def check(config: Config = None, settings: Settings = None, json: Json = False, **more: Any) -> int:
    """Inspect an experiment before running it.

    Shows step, hydraulic mode and bands, record, leakage, stroke and sensor noise, and how well a healthy
    record determines the unknowns of model-based indicators.

    Simulates up to 60 of the runs that differ in more than their sensors; step limits cover all runs.
    Exit code 1 if results would be wrong.
    """
    from hydrofdi.api.check import check as look
    from hydrofdi.api.experiments import experiment_with
    from hydrofdi.config.shown_values import shown_in

    experiment = experiment_with(config, settings or ())
    found = look(experiment, **more)
    with shown_in(experiment.units):
        answer(found, _parts, json=json)
    return 0 if found else 1


def _parts(check: Check) -> Iterator[Any]:
    """Step, modes, record, noise, what a record tells estimators, and warnings."""
    from rich.text import Text

    from hydrofdi.api.check_tables import convergence_table, modes_table, noise_table

    found = check.inspection
    limits = sorted(found.step_limits.items(), key=lambda item: item[1])
    yield Text("Step", "bold")
    yield (
        f"{convert(found.step, 'ms'):g} ms, limited by {found.binding}; stable up to [ms]: "
        + ", ".join(f"{part} {convert(limit, 'ms'):.3g}" for part, limit in limits)
    )
    yield from ("", Text("Hydraulic mode", "bold"), modes_table(found))
    if found.n_left_out:
        yield f"left out: {counted(found.n_left_out, 'further run')}"
    yield from ("", Text("Record", "bold"))
    shares = ", ".join(f"d{level} {share:.1%}" for level, share in enumerate(found.boundary_shares, 1))
    periods = f", {counted(found.n_period, 'period')}" if math.isfinite(found.n_period) else ""
    yield f"{counted(found.n_sample, 'sample')}{periods}; coefficients at its ends: {shares}"
    if found.noise:
        yield from ("", noise_table(found))
    for estimator in found.observability:
        yield from ("", *_observability(estimator))
    yield ""
    yield from (Text(f"problem: {problem}", "bold red") for problem in found.problems)
    yield from (Text(f"warning: {warning}") for warning in check.warnings)
    if not found.problems and not check.warnings:
        yield "no warnings"
    if check.convergence is not None:
        yield from ("", convergence_table(check.convergence))


def _observability(found: Observability) -> Iterator[Any]:
    """Each unknown before and after a record, the least known direction, and collinear pairs."""
    from hydrofdi.api.check_tables import unknowns_table

    yield unknowns_table(found)
    if not found.unknowns:
        yield "nothing: the estimate diverges; do its options fit the actuator?"
    elif not any(found.singular_values):
        yield "the record contains no information on them; does the valve open?"
    else:
        condition = f"{found.condition:.2g}" if math.isfinite(found.condition) else "infinite"
        left = f"{found.weakest_left:.0%} of the prior deviation remains"
        yield f"condition number {condition}; least known: {found.weakest}: {left}"
        pairs = ", ".join(f"{one} and {other} ({value:+.3f})" for one, other, value in found.collinear)
        yield f"collinear: {pairs or 'none'}"


def calibrate(config: Config = None, settings: Settings = None, json: Json = False, **more: Any) -> int:
    """Compute the coefficients K_i of mean leakage flows.

    They are valid under the conditions of the baseline.
    """
    from dataclasses import asdict

    from hydrofdi.api.check import calibrate as solve
    from hydrofdi.api.check import refuse_flow
    from hydrofdi.api.check_tables import targets_table
    from hydrofdi.api.experiments import experiment_with

    refuse_flow(config)
    targets = solve(experiment_with(config, settings or ()), **more)
    record = {"targets": [asdict(target) for target in targets]}
    answer(record, lambda _: [targets_table(targets)], json=json)
    return 0
