"""Measured files and their descriptions, written and read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hydrofdi.records import Channel, RecordBatch
from hydrofdi.records.measured.source import measured_source

P1, P2, SUPPLY = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.SUPPLY_PRESSURE
POSITION, VOLTAGE = Channel.PISTON_POSITION, Channel.INPUT_VOLTAGE

USUAL = """\
files: "*.csv"
sampling_frequency: 1 kHz
channels: {chamber_1_pressure: {column: P1, unit: bar}}
"""


def described(folder: Path, description: str = USUAL, **texts: str) -> Path:
    """A description in a folder, and files beside it: name, with ``_`` for the dot → text."""
    for name, text in texts.items():
        (folder / name.replace("_", ".")).write_text(text, encoding="utf-8")
    file = folder / "measured.yaml"
    file.write_text(description, encoding="utf-8")
    return file


def batches(folder: Path, description: str = USUAL, **texts: str) -> list[RecordBatch]:
    """All batches of files that are described."""
    return list(measured_source(described(folder, description, **texts)).batches(labels=True))


def one(folder: Path, description: str = USUAL, **texts: str) -> RecordBatch:
    """The only batch."""
    (batch,) = batches(folder, description, **texts)
    return batch


def kinds(batch: RecordBatch, row: int = 0) -> set[str]:
    """Kinds of the remarks on a record."""
    return {remark.kind for remark in batch.remarks[row]}


def csv_of(*columns: tuple[str, object], sign: str = ",") -> str:
    """A CSV of named columns."""
    rows = np.column_stack([np.asarray(values, dtype=float) for _, values in columns])
    lines = [sign.join(name for name, _ in columns)]
    return "\n".join(lines + [sign.join(map(repr, row)) for row in rows.tolist()]) + "\n"
