"""``hydrofdi train``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, SamplingFrequency, Sources
from hydrofdi.errors import without_credentials
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.api.detectors.healthy_records import LeftOut


def train(
    sources: Sources,
    out: Annotated[Path, typer.Option(metavar="FILE", help="JSON file to write the detector to.")],
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
    **settings: Any,
) -> int:
    """Train a detector on healthy records and show the evidence for its false-alarm rate.

    Uses the records with a healthy label, the runs of a sweep without a leak, or the healthy fit records of a
    study; all records if they have no labels. If there are too few, a message says how many are needed.
    Exit code 1 if records are rejected or repeat the samples of another.
    """
    from hydrofdi.api.detectors.training import train as train_detector
    from hydrofdi.cli.terminal import print_json, terminal

    detector = train_detector(
        sources,
        out=out,
        command=shlex.join(["hydrofdi", *map(without_credentials, sys.argv[1:])]),
        sampling_frequency=sampling_frequency,
        **settings,
    )
    if json:
        print_json({"out": str(out), **detector.to_dict()})
    else:
        terminal().print(f"{out}: {detector.name}\n{detector.summary}")
    return _tell(detector.left_out)


def options() -> dict[str, Any]:
    """The options that follow from the function and the configuration of a detector."""
    from hydrofdi.api.detectors.training import setting_keys
    from hydrofdi.api.detectors.training import train as train_detector
    from hydrofdi.cli.options import options_like, options_of
    from hydrofdi.detectors.trained.configuration import DetectorConfig

    keys = options_of(DetectorConfig, setting_keys())
    return options_like(train_detector, "healthy", "config") | keys


def _tell(left: LeftOut) -> int:
    from hydrofdi.cli.terminal import tell

    if left.n_rejected:
        tell(f"rejected: {counted(left.n_rejected, 'record')}; {left.first_rejection}")
    if left.n_repeated:
        tell(f"left out as repeats: {counted(left.n_repeated, 'record')}; {left.first_repeat}")
    return 1 if left.n_rejected or left.n_repeated else 0
