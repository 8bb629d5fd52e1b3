"""Output of ``check`` and ``calibrate``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.text import Text

from hydrofdi.cli.mode_table import cell, print_modes
from hydrofdi.cli.observability_table import print_observability
from hydrofdi.cli.parted_table import PartedTable
from hydrofdi.cli.terminal import terminal
from hydrofdi.settings.counting import counted
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.check import Check
    from hydrofdi.api.inspection import Inspection
    from hydrofdi.api.selection import Convergence, LeakageTarget


def print_inspection(check: Check) -> None:
    """Print an inspection: step, modes, record, and warnings."""
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
    print_modes(found)
    if found.n_left_out:
        console.print(f"left out: {counted(found.n_left_out, 'further run')}")
    console.print()
    console.print(Text("Record", style="bold"))
    shares = ", ".join(f"d{level} {share:.1%}" for level, share in enumerate(found.boundary_shares, 1))
    periods = f", {counted(found.n_period, 'period')}" if math.isfinite(found.n_period) else ""
    console.print(f"{counted(found.n_sample, 'sample')}{periods}; coefficients at its ends: {shares}\n")
    if found.noise:
        console.print(Text("Noise of the chamber-1 pressure sensor", style="bold"))
        console.print(_noise_table(found))
        console.print()
    for estimator in found.observability:
        print_observability(estimator)
        console.print()
    for problem in found.problems:
        console.print(Text(f"problem: {problem}", style="bold red"))
    for warning in check.warnings:
        console.print(f"warning: {warning}", soft_wrap=True)
    if not found.problems and not check.warnings:
        console.print("no warnings")


def _noise_table(found: Inspection) -> PartedTable:
    shown = PartedTable(["level", "noise\nkPa", "weakest run\nkPa", "share\n"])
    for level, noise in enumerate(found.noise, 1):
        shown.add_row(
            f"d{level}",
            f"{convert(noise.noise, 'kPa'):.3g}",
            cell(convert(noise.weakest_rms, "kPa"), ".4g"),
            cell(noise.share, ".1%"),
        )
    return shown


def print_convergence(found: Convergence) -> None:
    """Print the change of the features from step to step, and the step that is good enough."""
    console = terminal()
    console.print(Text("\nLargest change of the detail RMS when the step is halved", style="bold"))
    shown = PartedTable(["step [ms]", *(f"d{level}" for level in range(1, len(found.changes[0]) + 1))])
    for step, change in zip(found.steps, found.changes, strict=True):
        shown.add_row(f"{convert(step, 'ms'):g}", *(f"{value:.1e}" for value in change))
    console.print(shown)
    if found.good_enough is None:
        console.print(f"no step down to {found.steps[-1]:g} s stays within {found.tolerance:g}")
    else:
        console.print(f"a step of {convert(found.good_enough, 'ms'):g} ms stays within {found.tolerance:g}")


def print_targets(targets: Sequence[LeakageTarget]) -> None:
    """Print leakage flows with their coefficients."""
    shown = PartedTable(
        ["mean leakage\nL/min", "K_i (orifice)\nm³/s/√Pa", "laminar\nm³/(s·Pa)", "of piston\nflow"]
    )
    for target in targets:
        shown.add_row(
            f"{convert(target.flow, 'L/min'):.4g}",
            f"{target.coefficient:.6g}",
            f"{target.laminar_coefficient:.4g}",
            f"{target.piston_share:.2%}",
        )
    terminal().print(shown)
