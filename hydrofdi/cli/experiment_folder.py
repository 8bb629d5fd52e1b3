"""Questions to an experiment's folder: ``status``, ``verify``, ``why``, ``rerun``, and ``collect``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of an experiment.")]
Run = Annotated[str, typer.Argument(metavar="RUN", help="Beginning of a run's identity, or its position.")]


def status(directory: Directory, json: Json = False) -> int:
    """Show sweep progress, and which shards are damaged.

    Exit code 1 when runs failed or a shard is damaged.
    """
    from dataclasses import asdict

    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.pipeline import sweep_status

    state = sweep_status(directory)
    if json:
        print_json(asdict(state))
    else:
        details = ", ".join(f"{count} {name}" for name, count in sorted(state.statuses.items()))
        write_out(
            f"{state.planned} planned, {state.done} done, {state.failed} failed,"
            f" {state.missing} missing ({details})\n"
        )
        if state.earlier:
            write_out(
                f"{state.earlier} runs were stored by an earlier version of the physics;"
                " 'hydrofdi report' reads them, and a sweep computes them again\n"
            )
        write_out("".join(f"{fault}; the next sweep computes its runs again\n" for fault in state.damaged))
    return 1 if state.failed or state.damaged else 0


def verify(directory: Directory, json: Json = False) -> int:
    """Check every shard of a folder against its checksum.

    Also the index and the experiment file. Exit code 1 when anything is off.
    """
    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.pipeline import verify as find_faults

    faults = find_faults(directory)
    if json:
        print_json({"sound": not faults, "faults": faults})
    else:
        write_out("\n".join(faults or ["every shard is sound"]) + "\n")
    return 1 if faults else 0


def why(directory: Directory, run: Run, json: Json = False) -> int:
    """Show the request of a run and its outcome.

    With its differences from the baseline, and what it was computed with.
    """
    from dataclasses import asdict

    from hydrofdi.cli.explanation import print_explanation
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.pipeline import explain

    explanation = explain(directory, run)
    if json:
        print_json(asdict(explanation))
    else:
        print_explanation(explanation)
    return 0


def rerun(directory: Directory, run: Run, json: Json = False) -> int:
    """Compute a stored run again and compare the bits.

    Exit code 1 when they differ.
    """
    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.pipeline import recompute

    run_id, differing = recompute(directory, run)
    if json:
        print_json({"run_id": run_id, "same_bits": not differing, "differing": differing})
    elif differing:
        write_out(f"run {run_id}: differs in {', '.join(differing)}\n")
    else:
        write_out(f"run {run_id}: the same bits\n")
    return 1 if differing else 0


def collect(directory: Directory) -> int:
    """Build the experiment file from what is stored.

    Runs without a result become holes with a reason.
    """
    from hydrofdi.cli.terminal import tell
    from hydrofdi.pipeline import collect as build_file
    from hydrofdi.pipeline import sweep_status

    file = build_file(directory)
    state = sweep_status(directory)
    tell(
        f"stored {file}: {state.planned} runs, of which {state.missing} are missing and {state.failed} failed"
    )
    return 0
