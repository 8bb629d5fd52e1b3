"""What ``why`` shows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.text import Text

from hydrofdi.cli.terminal import terminal
from hydrofdi.config.shown_values import shown_value
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.pipeline.inspecting import Explanation


def print_explanation(explanation: Explanation) -> None:
    """What a run was asked to do and how it went."""
    console = terminal()
    console.print(
        Text(
            f"run {explanation.run_id}, row {explanation.position}, record {explanation.record_id}",
            style="bold",
        )
    )
    console.print(f"status    {explanation.status} {explanation.message}".rstrip())
    if explanation.reason:
        console.print(f"to do     {explanation.reason}")
    for cause in explanation.causes:
        console.print(f"because   {cause}")
    console.print(f"stored in {explanation.shard or 'nothing'}")
    for label, analysis in explanation.analysis.items():
        options = ", ".join(f"{name} {value}" for name, value in analysis["options"].items())
        console.print(Text(f"analysis  {label} {analysis['analysis_id']}: {options or 'default options'}"))
    grid = Table(title="differs from the fixed baseline in", title_justify="left", box=None, pad_edge=False)
    for header in ("parameter", "baseline", "run"):
        grid.add_column(header)
    for name, (before, now) in explanation.differences.items():
        grid.add_row(name, _shown(name, before), _shown(name, now))
    console.print(grid if explanation.differences else "is the fixed baseline itself")
    if explanation.calibration:
        beta = convert(explanation.calibration["fluid"]["bulk_modulus"], "MPa")
        console.print(f"K_i was solved at an EBM of {beta:g} MPa, other baseline conditions alike")
    if explanation.provenance:
        made = explanation.provenance
        git = made["git"] or {"commit": "unknown", "dirty": False}
        console.print(
            f"swept {made['started']} by: {' '.join(made['command'])}\n"
            f"commit {git['commit']}{' with changes' if git['dirty'] else ''}, Python {made['python']},"
            f" seeds {made['seeds'] or 'none'}"
        )
    if explanation.log:
        console.print(explanation.log)


def _shown(name: str, value: Any) -> str:
    return "–" if value is None else shown_value(name, value)
