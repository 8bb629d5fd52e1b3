"""``hydrofdi schema``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer


class Kind(StrEnum):
    """Kinds of files."""

    EXPERIMENT = "experiment"
    MEASURED = "measured"
    MONITOR = "monitor"
    DETECTOR = "detector"


def schema(
    kind: Annotated[Kind, typer.Argument(help="Kind of file that the schema describes.")] = Kind.EXPERIMENT,
) -> int:
    """Print the JSON Schema of a kind of file, for editors and programs.

    Experiment files, descriptions of measured files, configurations of 'hydrofdi monitor', and the detector
    files that 'hydrofdi train' writes.
    """
    from hydrofdi.api.schemas import schema as schema_of
    from hydrofdi.cli.terminal import print_json

    print_json(schema_of(kind.value))
    return 0
