"""``hydrofdi schema``."""

from __future__ import annotations

from typing import Annotated, Literal

import typer


def schema(
    kind: Annotated[
        Literal["experiment", "measured", "monitor", "detector"],
        typer.Argument(help="Kind of file that the schema describes."),
    ] = "experiment",
) -> int:
    """Print the JSON Schema of a kind of file, for editors and programs.

    Experiment files, descriptions of measured files, configurations of 'hydrofdi monitor', and the detector
    files that 'hydrofdi train' writes.
    """
    from hydrofdi.api.schemas import schema as schema_of
    from hydrofdi.cli.terminal import print_json

    print_json(schema_of(kind))
    return 0
