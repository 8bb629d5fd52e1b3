"""``hydrofdi verify``, ``why`` and ``rerun``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Directory, Json
from hydrofdi.cli.terminal import answer, facts, print_json, write_out

if TYPE_CHECKING:
    from hydrofdi.api.folders import Explanation
    from hydrofdi.report.table import Table

Run = Annotated[
    str, typer.Argument(metavar="RUN", help="First characters of a run's identity, or its position.")
]


def verify(directory: Directory, json: Json = False) -> int:
    """Check every shard of a folder against its checksum.

    Also checks the index and the experiment file. Exit code 1 if anything is wrong.
    """
    from hydrofdi.api.folders import verify as find_faults

    found = find_faults(directory)
    if json:
        print_json({"sound": bool(found), "faults": found.faults})
    else:
        write_out("\n".join(found.faults or [str(found)]) + "\n")
    return 0 if found else 1


def why(directory: Directory, run: Run, json: Json = False, **settings: Any) -> int:
    """Explain a run: its settings, verdict and what changed.

    Also shows its differences from the baseline, its failure, and how it was computed.
    """
    from hydrofdi.api.folders import why as explain
    from hydrofdi.config.shown_values import shown_in

    explanation = explain(directory, run, **settings)
    if json:
        print_json(vars(explanation))
        return 0
    with shown_in(explanation.units):
        answer(explanation, _explanation, json=False)
    return 0


def _explanation(run: Explanation) -> Iterator[Any]:
    """The request of a run, its result, and what changed since."""
    from rich.text import Text

    from hydrofdi.config.shown_values import shown_value

    yield Text(f"run {run.run_id}, row {run.position}, record {run.record_id}", "bold")
    yield from facts([
        ("status", f"{run.status} {run.message}".rstrip()),
        ("remedy", run.remedy),
        ("verdict", run.verdict if run.verdict != run.status else ""),
        *(("", f"{word}: {told['meaning']}; {told['remedy']}") for word, told in run.doubts.items()),
        ("to do", run.reason),
        *(("because", cause) for cause in run.causes),
    ])  # fmt: skip
    if run.changes:
        yield _pairs("changed since runs were stored", ("key", "before", "now"), run.changes)
    yield f"stored in {run.shard or 'nothing'}"
    for label, analysis in run.analysis.items():
        yield f"analysis  {label} {analysis['analysis_id']}: {analysis['shown'] or 'default options'}"
    if run.differences:
        heads = ("parameter", "baseline", "run")
        yield _pairs("differs from the fixed baseline in", heads, run.differences)
    elif run.is_baseline:
        yield "This run is the fixed baseline."
    else:
        yield "This run has the same parameters as the baseline."
    if run.calibration:
        modulus = shown_value("fluid.bulk_modulus", run.calibration["fluid"]["bulk_modulus"])
        yield f"K_i was computed at an EBM of {modulus}, under the other baseline conditions"
    if made := run.provenance:
        from hydrofdi.config.seeds import shown_seeds

        git, seeds = made["git"] or {"commit": "unknown", "dirty": False}, made["seeds"]
        shown = shown_seeds(seeds) if isinstance(seeds, dict) else ", ".join(map(str, seeds)) or "none"
        yield f"swept {made['started']} by: {' '.join(made['command'])}"
        yield f"commit {git['commit']}{' with changes' if git['dirty'] else ''}, Python {made['python']}"
        yield f"seeds     {shown}"
    if run.log:
        yield run.log


def _pairs(title: str, headers: tuple[str, str, str], pairs: Mapping[str, tuple[Any, Any]]) -> Table:
    """A table of names, each with two values in readable units."""
    from hydrofdi.report.table import Table

    values = ([_shown(name, both[place]) for name, both in pairs.items()] for place in (0, 1))
    return Table.of(dict(zip(headers, ([*pairs], *values), strict=True)), title=title)


def _shown(name: str, value: Any) -> str:
    """A value, or the values of an axis, such as ``sweep.grid: fluid.bulk_modulus``."""
    from json import dumps

    from hydrofdi.config.request import parameter_names
    from hydrofdi.config.shown_values import shown_value
    from hydrofdi.settings.readable import HOLE

    parameter = name.rpartition(": ")[2]
    if value is None:
        return HOLE
    if parameter not in set(parameter_names()):
        return value if isinstance(value, str) else dumps(value)
    return ", ".join(shown_value(parameter, each) for each in (value if isinstance(value, list) else [value]))


def rerun(directory: Directory, run: Run, json: Json = False) -> int:
    """Recompute a stored run and compare it bit for bit.

    Exit code 1 if the two results differ.
    """
    from hydrofdi.api.folders import rerun as compute_again

    found = compute_again(directory, run)
    if json:
        print_json({"run_id": found.run_id, "same_bits": bool(found), "differing": found.differing})
    else:
        write_out(f"{found}\n")
    return 0 if found else 1
