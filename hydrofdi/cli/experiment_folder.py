"""Commands on an experiment's folder: ``status``, ``verify``, ``why``, ``rerun``, and ``collect``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json
from hydrofdi.settings.counting import counted

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of an experiment.")]
Run = Annotated[
    str, typer.Argument(metavar="RUN", help="First characters of a run's identity, or its position.")
]


def status(directory: Directory, json: Json = False) -> int:
    """Show sweep progress and damaged shards.

    Exit code 1 if runs failed or a shard is damaged.
    """
    from dataclasses import asdict

    from hydrofdi.api.folders import status as look
    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.quality.doubts import doubt_lines

    state = look(directory)
    if json:
        print_json(asdict(state))
    else:
        write_out(f"{state}\n")
        write_out("".join(f"{line}\n" for line in doubt_lines(state.verdicts)))
        if state.earlier:
            write_out(
                f"stored by an earlier version of the physics: {counted(state.earlier, 'run')};"
                " 'hydrofdi report' reads them, and a sweep computes them again\n"
            )
        write_out("".join(f"{fault}; the next sweep computes its runs again\n" for fault in state.damaged))
    return 1 if state.failed or state.damaged else 0


def verify(directory: Directory, json: Json = False) -> int:
    """Check every shard of a folder against its checksum.

    Also checks the index and the experiment file. Exit code 1 if anything is wrong.
    """
    from hydrofdi.api.folders import verify as find_faults
    from hydrofdi.cli.terminal import print_json, write_out

    found = find_faults(directory)
    if json:
        print_json({"sound": bool(found), "faults": found.faults})
    else:
        write_out("\n".join(found.faults or [str(found)]) + "\n")
    return 0 if found else 1


def why(
    directory: Directory,
    run: Run,
    config: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Compare with this experiment file, not the latest request."),
    ] = None,
    json: Json = False,
) -> int:
    """Explain a run: its settings, verdict and what changed.

    Also shows its differences from the baseline, its failure, and how it was computed.
    """
    from hydrofdi.api.folders import why as explain
    from hydrofdi.cli.explanation import print_explanation
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.config.shown_values import shown_in

    explanation = explain(directory, run, config)
    if json:
        print_json(vars(explanation))
    else:
        with shown_in(explanation.units):
            print_explanation(explanation)
    return 0


def rerun(directory: Directory, run: Run, json: Json = False) -> int:
    """Recompute a stored run and compare it bit for bit.

    Exit code 1 if the two results differ.
    """
    from hydrofdi.api.folders import rerun as compute_again
    from hydrofdi.cli.terminal import print_json, write_out

    found = compute_again(directory, run)
    if json:
        print_json({"run_id": found.run_id, "same_bits": bool(found), "differing": found.differing})
    else:
        write_out(f"{found}\n")
    return 0 if found else 1


def collect(directory: Directory, json: Json = False) -> int:
    """Build the experiment file from the stored runs.

    Runs without a result are marked as missing, with the reason.
    """
    from hydrofdi.api.folders import collect as build_file
    from hydrofdi.api.folders import status as look
    from hydrofdi.cli.terminal import print_json, tell

    made, state = build_file(directory), look(directory)
    if json:
        record = {"planned": state.planned, "missing": state.missing, "failed": state.failed}
        print_json({"file": str(made.file), **record})
    tell(
        f"stored {made.file}: {counted(state.planned, 'run')}, {state.missing:,}"
        f" missing, {state.failed:,} failed"
    )
    return 0
