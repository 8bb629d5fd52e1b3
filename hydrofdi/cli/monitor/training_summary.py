"""What a trained detector promises, and what the promise rests on, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrofdi.detectors.trained import DetectorFile
    from hydrofdi.pipeline.training import Training

_HOUR = 3600.0


def training_record(training: Training, out: Path) -> dict[str, Any]:
    """The same for a program."""
    return {
        "out": str(out),
        "detector": training.file.model_dump(mode="json", by_alias=True),
        "left_out": asdict(training.left_out),
        "false_alarms_per_hour": _per_hour(training.file),
        "summary": list(sentences(training)),
    }


def print_training(training: Training, out: Path) -> None:
    """Print the sentences."""
    from hydrofdi.cli.terminal import terminal

    console = terminal()
    console.print(f"{out}: {training.file.config.indicator}.{training.file.config.output}")
    for sentence in sentences(training):
        console.print(f"  {sentence}")


def sentences(training: Training) -> Iterator[str]:
    """What the detector judges, what it promises, and what that rests on."""
    file = training.file
    yield f"Judges {_what(file)} of {' and '.join(file.channels)} at {file.sampling_frequency:g} Hz."
    yield f"Raises an alarm {_limits(file)}."
    yield _promise(file)
    yield from _basis(training)
    yield from _chart(file)


def _what(file: DetectorFile) -> str:
    window = file.config.window
    if window.by == "estimate":
        return "each estimate"
    if window.by == "cycle":
        return f"the first {window.duration:g} s of each cycle of {window.channel}"
    duration, every = window.duration or 0.0, window.every or 0.0
    overlap = "" if every >= duration else f", one every {every:g} s,"
    return f"windows of {duration:g} s{overlap}"


def _limits(file: DetectorFile) -> str:
    from hydrofdi.detectors.trained.wording import readable

    limits = file.limits
    low = "" if limits.low is None else f"below {readable(limits.low, file.unit)}"
    high = "" if limits.high is None else f"above {readable(limits.high, file.unit)}"
    return " or ".join(part for part in (low, high) if part)


def _promise(file: DetectorFile) -> str:
    limits = file.limits
    low, high = (f"{100 * share:.3g} %" for share in limits.interval)
    rests = {
        "windows": "taking windows as independent",
        "records": "where each record met the limits of the others",
        "groups": "where each group met the limits of the others",
    }
    return (
        f"Promises {100 * limits.false_alarm_rate:.3g} % of false alarms; the true rate lies within {low} and"
        f" {high} ({100 * limits.confidence:.4g} % confidence, {rests[limits.interval_rests_on]})."
    )


def _basis(training: Training) -> Iterator[str]:
    basis, left = training.file.basis, training.left_out
    what = "estimates" if not training.file.n_sample else "windows that do not overlap"
    groups = f" in {basis.n_group:,} groups" if basis.n_group else ""
    yield f"Rests on {basis.n_window:,} {what}, of {basis.n_record:,} healthy records{groups}."
    if basis.n_record == 1:
        yield "One record: nothing is known of other days or machines."
    if training.is_unlabelled:
        yield "No record has a label: all are taken as healthy."
    if left.n_leaking:
        yield f"{left.n_leaking:,} records are left out because they are not known to be healthy."


def _chart(file: DetectorFile) -> Iterator[str]:
    if file.chart is not None and file.config.chart is not None:
        yield f"{file.config.chart.chart}: limit {file.chart.limit:.4g} on {file.chart.hours:.3g} h."


def _per_hour(file: DetectorFile) -> list[float] | None:
    every = file.config.window.every
    return None if every is None else [share * _HOUR / every for share in file.limits.interval]
