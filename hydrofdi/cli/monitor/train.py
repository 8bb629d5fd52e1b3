"""``hydrofdi train``."""

from __future__ import annotations

import shlex
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Json, SamplingFrequency
from hydrofdi.errors import without_credentials
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.api.detectors.healthy_records import LeftOut


class By(StrEnum):
    """What is judged."""

    TIME = "time"
    CYCLE = "cycle"
    ESTIMATE = "estimate"


class Departure(StrEnum):
    """Direction of change that raises an alarm."""

    RISING = "rising"
    FALLING = "falling"
    BOTH = "both"


class Rule(StrEnum):
    """Rules that set limits."""

    QUANTILE = "quantile"
    TOLERANCE = "tolerance"


def train(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="Healthy records: a results folder, an experiment file (.h5, or .yaml to be simulated), a"
            " description of measured files, or one data file.",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="JSON file to write the detector to.")],
    indicator: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Indicator to measure [default: dwt]; its label if --config has several."
        ),
    ] = None,
    false_alarm_rate: Annotated[
        str | None,
        typer.Option(metavar="RATE", help="Share of healthy windows that may raise an alarm [default: 1 %]."),
    ] = None,
    output: Annotated[
        str | None, typer.Option(metavar="NAME", help="Output of the indicator that is the score.")
    ] = None,
    direction: Annotated[
        Departure | None,
        typer.Option(help="Direction of change that raises an alarm [default: from the output]."),
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="Duration of a window, e.g. '20 s' [default: length of the records]."
        ),
    ] = None,
    every: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help="Time between the starts of windows; if it is shorter than a window, windows overlap.",
        ),
    ] = None,
    by: Annotated[
        By | None,
        typer.Option(
            help="Windows by time or by cycle of the drive, or each estimate of a recursive indicator."
        ),
    ] = None,
    confidence: Annotated[
        str | None,
        typer.Option(metavar="SHARE", help="Confidence of the interval of the rate [default: 95 %]."),
    ] = None,
    threshold: Annotated[
        Rule | None,
        typer.Option(help="Keep the rate on average (quantile), or with the confidence (tolerance)."),
    ] = None,
    healthy: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LABEL", help="Label of healthy records, in addition to 'healthy:'. Repeatable."
        ),
    ] = None,
    accept: Annotated[
        bool,
        typer.Option("--accept", help="Train although estimates are physically impossible in most windows."),
    ] = False,
    config: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="YAML file with the same settings, options and a chart; the command line takes precedence.",
        ),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Train a detector on healthy records and show the evidence for its false-alarm rate.

    Uses the records with a healthy label, the runs of a sweep without a leak, or the healthy fit records of a
    study; all records if they have no labels. If there are too few, a message says how many are needed.
    Exit code 1 if records are rejected or repeat the samples of another.
    """
    from hydrofdi.api.detectors.training import train as train_detector
    from hydrofdi.cli.terminal import print_json, terminal
    from hydrofdi.settings.yaml_source import scalar

    detector = train_detector(
        sources,
        indicator,
        config=config,
        output=output,
        direction=None if direction is None else direction.value,
        window=None if window is None else scalar(window),
        every=None if every is None else scalar(every),
        by=None if by is None else by.value,
        false_alarm_rate=false_alarm_rate,
        confidence=confidence,
        threshold=None if threshold is None else threshold.value,
        accept=accept or None,
        healthy=healthy or (),
        out=out,
        command=shlex.join(["hydrofdi", *map(without_credentials, sys.argv[1:])]),
        sampling_frequency=sampling_frequency,
    )
    if json:
        print_json({"out": str(out), **detector.to_dict()})
    else:
        terminal().print(f"{out}: {detector.name}\n{detector.summary}")
    return _tell(detector.training.left_out)


def _tell(left: LeftOut) -> int:
    from hydrofdi.cli.terminal import tell

    if left.n_rejected:
        tell(f"rejected: {counted(left.n_rejected, 'record')}; {left.first_rejection}")
    if left.n_repeated:
        tell(f"left out as repeats: {counted(left.n_repeated, 'record')}; {left.first_repeat}")
    return 1 if left.n_rejected or left.n_repeated else 0
