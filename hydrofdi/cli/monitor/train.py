"""``hydrofdi train``."""

from __future__ import annotations

import shlex
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, SamplingFrequency, frequency
from hydrofdi.errors import without_credentials

if TYPE_CHECKING:
    from hydrofdi.pipeline.healthy_records import LeftOut


class By(StrEnum):
    """What is judged."""

    TIME = "time"
    CYCLE = "cycle"
    ESTIMATE = "estimate"


class Departure(StrEnum):
    """Which departure raises an alarm."""

    RISING = "rising"
    FALLING = "falling"
    BOTH = "both"


class Rule(StrEnum):
    """How limits are set."""

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
    out: Annotated[Path, typer.Option(metavar="FILE", help="Where the detector is written, as JSON.")],
    indicator: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="What is measured [default: dwt]; a label, where --config has several."
        ),
    ] = None,
    false_alarm_rate: Annotated[
        str | None,
        typer.Option(metavar="RATE", help="Share of healthy windows that may raise an alarm [default: 1 %]."),
    ] = None,
    output: Annotated[
        str | None, typer.Option(metavar="NAME", help="Which number of the indicator is the score.")
    ] = None,
    direction: Annotated[
        Departure | None,
        typer.Option(help="Which departure raises an alarm; that of the output if left out."),
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="Duration of a window, e.g. '20 s'; that of the records if left out."
        ),
    ] = None,
    every: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="From the start of one window to the next; less makes them overlap."
        ),
    ] = None,
    by: Annotated[
        By | None,
        typer.Option(
            help="Windows by time or by cycle of the drive, or each estimate of a recursive indicator."
        ),
    ] = None,
    confidence: Annotated[
        str | None, typer.Option(metavar="SHARE", help="Of the interval of the rate [default: 95 %].")
    ] = None,
    threshold: Annotated[
        Rule | None,
        typer.Option(help="Keep the rate on average (quantile), or with the confidence (tolerance)."),
    ] = None,
    healthy: Annotated[
        list[str] | None,
        typer.Option(metavar="LABEL", help="Label of healthy records, beside 'healthy:'. Repeatable."),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="YAML with the same settings, options and a chart; options here win."
        ),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Train a detector on healthy records, and say what its promise rests on.

    Of labelled records those with a healthy label are used, of a sweep the runs without a leak, of a study
    its healthy fit records; of other records all. Too few records are refused with the number that is needed.
    Exit code 1 where records are rejected or repeat the samples of another.
    """
    from hydrofdi.cli.monitor.training_summary import print_training, training_record
    from hydrofdi.cli.terminal import print_json
    from hydrofdi.detectors.trained.training import stated_detector
    from hydrofdi.pipeline.training import require_place, train_on, write_detector

    given: dict[tuple[str, ...], tuple[str, Any]] = {
        ("indicator",): ("--indicator", indicator),
        ("output",): ("--output", output),
        ("direction",): ("--direction", direction),
        ("false_alarm_rate",): ("--false-alarm-rate", false_alarm_rate),
        ("confidence",): ("--confidence", confidence),
        ("threshold",): ("--threshold", threshold),
        ("window", "duration"): ("--window", window),
        ("window", "every"): ("--every", every),
        ("window", "by"): ("--by", by),
    }
    stated = stated_detector(config, {key: each for key, each in given.items() if each[1] is not None})
    require_place(out)
    training = train_on(
        sources,
        stated,
        healthy=healthy or (),
        sampling_frequency=frequency(sampling_frequency),
        command=shlex.join(["hydrofdi", *map(without_credentials, sys.argv[1:])]),
    )
    write_detector(out, training.file)
    if json:
        print_json(training_record(training, out))
    else:
        print_training(training, out)
    return _tell(training.left_out)


def _tell(left: LeftOut) -> int:
    from hydrofdi.cli.terminal import tell

    if left.n_rejected:
        tell(f"rejected: {_records(left.n_rejected)}; {left.first_rejection}")
    if left.n_repeated:
        tell(f"left out as repeats: {_records(left.n_repeated)}; {left.first_repeat}")
    return 1 if left.n_rejected or left.n_repeated else 0


def _records(count: int) -> str:
    return f"{count:,} record{'s' if count != 1 else ''}"
