"""Output of ``why``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rich.text import Text

from hydrofdi.cli.tables import print_table
from hydrofdi.cli.terminal import terminal
from hydrofdi.config.request import parameter_names
from hydrofdi.config.seeds import shown_seeds
from hydrofdi.config.shown_values import shown_value
from hydrofdi.report.table import Table
from hydrofdi.settings.readable import HOLE

if TYPE_CHECKING:
    from hydrofdi.api.folders import Explanation


def print_explanation(explanation: Explanation) -> None:
    """Print the request of a run, its result, and what changed since."""
    console = terminal()
    title = f"run {explanation.run_id}, row {explanation.position}, record {explanation.record_id}"
    console.print(Text(title, style="bold"))
    facts = [
        ("status", f"{explanation.status} {explanation.message}".rstrip()),
        ("remedy", explanation.remedy),
        ("verdict", explanation.verdict if explanation.verdict != explanation.status else ""),
        *(("", f"{word}: {told['meaning']}; {told['remedy']}") for word, told in explanation.doubts.items()),
        ("to do", explanation.reason),
        *(("because", cause) for cause in explanation.causes),
    ]
    for name, text in facts:
        if text:
            console.print(f"{name:<10}{text}")
    if explanation.changes:
        print_table(
            console, _pairs("changed since runs were stored", ("key", "before", "now"), explanation.changes)
        )
    console.print(f"stored in {explanation.shard or 'nothing'}")
    for label, analysis in explanation.analysis.items():
        options = analysis["shown"] or "default options"
        console.print(Text(f"analysis  {label} {analysis['analysis_id']}: {options}"))
    if explanation.differences:
        title = "differs from the fixed baseline in"
        print_table(console, _pairs(title, ("parameter", "baseline", "run"), explanation.differences))
    elif explanation.is_baseline:
        console.print("This run is the fixed baseline.")
    else:
        console.print("This run has the same parameters as the baseline.")
    if explanation.calibration:
        modulus = shown_value("fluid.bulk_modulus", explanation.calibration["fluid"]["bulk_modulus"])
        console.print(f"K_i was computed at an EBM of {modulus}, under the other baseline conditions")
    if explanation.provenance:
        _print_provenance(explanation.provenance)
    if explanation.log:
        console.print(explanation.log)


def _print_provenance(made: Mapping[str, Any]) -> None:
    git, seeds = made["git"] or {"commit": "unknown", "dirty": False}, made["seeds"]
    shown = shown_seeds(seeds) if isinstance(seeds, dict) else ", ".join(map(str, seeds)) or "none"
    terminal().print(
        f"swept {made['started']} by: {' '.join(made['command'])}\n"
        f"commit {git['commit']}{' with changes' if git['dirty'] else ''}, Python {made['python']}\n"
        f"seeds     {shown}"
    )


def _pairs(title: str, headers: tuple[str, str, str], pairs: Mapping[str, tuple[Any, Any]]) -> Table:
    """A table of names, each with two values in readable units."""
    values = ([_shown(name, both[place]) for name, both in pairs.items()] for place in (0, 1))
    return Table.of(dict(zip(headers, ([*pairs], *values), strict=True)), title=title)


def _shown(name: str, value: Any) -> str:
    """A value, or the values of an axis, such as ``sweep.grid: fluid.bulk_modulus``."""
    parameter = name.rpartition(": ")[2]
    if value is None:
        return HOLE
    if parameter not in set(parameter_names()):
        return value if isinstance(value, str) else json.dumps(value)
    values = value if isinstance(value, list) else [value]
    return ", ".join(shown_value(parameter, each) for each in values)
