"""Measured files and their descriptions, written and read."""

import numpy as np

from hydrofdi.records import Channel
from hydrofdi.records.measured.source import measured_source

P1, P2, SUPPLY = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.SUPPLY_PRESSURE
POSITION, VOLTAGE = Channel.PISTON_POSITION, Channel.INPUT_VOLTAGE

USUAL = """\
files: "*.csv"
sampling_frequency: 1 kHz
channels: {chamber_1_pressure: {column: P1, unit: bar}}
"""


def described(folder, description=USUAL, **texts):
    """A description in a folder, and files beside it: name, with ``_`` for the dot → text."""
    for name, text in texts.items():
        (folder / name.replace("_", ".")).write_text(text, encoding="utf-8")
    file = folder / "measured.yaml"
    file.write_text(description, encoding="utf-8")
    return file


def batches(folder, description=USUAL, **texts):
    """All batches of files that are described."""
    return list(measured_source(described(folder, description, **texts)).batches(labels=True))


def one(folder, description=USUAL, **texts):
    """The only batch."""
    (batch,) = batches(folder, description, **texts)
    return batch


def kinds(batch, row=0):
    """Kinds of the remarks on a record."""
    return {remark.kind for remark in batch.remarks[row]}


def csv_of(*columns, sign=","):
    """A CSV of named columns."""
    rows = np.column_stack([np.asarray(values, dtype=float) for _, values in columns])
    lines = [sign.join(name for name, _ in columns)]
    return "\n".join(lines + [sign.join(map(repr, row)) for row in rows.tolist()]) + "\n"
