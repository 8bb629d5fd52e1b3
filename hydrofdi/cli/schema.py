"""``hydrofdi schema``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer


class Kind(StrEnum):
    """What a file describes."""

    EXPERIMENT = "experiment"
    MEASURED = "measured"
    MONITOR = "monitor"
    DETECTOR = "detector"


def schema(
    kind: Annotated[Kind, typer.Argument(help="What the schema describes.")] = Kind.EXPERIMENT,
) -> int:
    """Print the JSON Schema of a kind of file, for editors and programs.

    Experiment files, descriptions of measured files, configurations of 'hydrofdi monitor', and the detector
    files that 'hydrofdi train' writes.
    """
    from hydrofdi.cli.terminal import print_json

    print_json(_schema(kind))
    return 0


def _schema(kind: Kind) -> dict[str, Any]:
    match kind:
        case Kind.EXPERIMENT:
            from hydrofdi.config.schema import experiment_schema

            return experiment_schema()
        case Kind.MEASURED:
            from hydrofdi.records.measured.description.schema import measured_schema

            return measured_schema()
        case Kind.MONITOR:
            from hydrofdi.monitor.configuration import monitor_schema

            return monitor_schema()
        case Kind.DETECTOR:
            from hydrofdi.detectors.trained.schema import detector_schema

            return detector_schema()
