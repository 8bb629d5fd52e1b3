"""``hydrofdi schema``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer


class Kind(StrEnum):
    """What a YAML describes."""

    EXPERIMENT = "experiment"
    MEASURED = "measured"


def schema(
    kind: Annotated[Kind, typer.Argument(help="Experiment files, or descriptions of measured files.")] = (
        Kind.EXPERIMENT
    ),
) -> int:
    """Print the JSON Schema of experiment files, or of descriptions of measured files, for editors."""
    from hydrofdi.cli.terminal import print_json

    if kind is Kind.MEASURED:
        from hydrofdi.records.measured.description.schema import measured_schema

        print_json(measured_schema())
    else:
        from hydrofdi.config.schema import experiment_schema

        print_json(experiment_schema())
    return 0
