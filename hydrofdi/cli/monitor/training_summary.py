"""What a trained detector promises, and what the promise rests on, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrofdi.detectors.trained import DetectorFile
    from hydrofdi.pipeline.training import Training


def training_record(training: Training, out: Path) -> dict[str, Any]:
    """The same for a program."""
    return {
        "out": str(out),
        "detector": training.file.model_dump(mode="json", by_alias=True),
        "left_out": asdict(training.left_out),
        "says": list(sentences(training)),
    }


def print_training(training: Training, out: Path) -> None:
    """Print the sentences."""
    from hydrofdi.cli.terminal import terminal

    console = terminal()
    console.print(f"{out}")
    for sentence in sentences(training):
        console.print(f"- {sentence}")


def sentences(training: Training) -> Iterator[str]:
    """What the detector is, what it promises, and what that rests on."""
    file = training.file
    yield f"score: {file.config.indicator}.{file.config.output}"
