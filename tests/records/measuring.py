"""Measured files and their descriptions, written and read."""

import h5py
import numpy as np
import pyarrow
import scipy.io
from pyarrow import parquet

from hydrofdi.records import Channel
from hydrofdi.records.source import measured_source, plain_source

P1, P2, SUPPLY = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.SUPPLY_PRESSURE
POSITION, VOLTAGE = Channel.PISTON_POSITION, Channel.INPUT_VOLTAGE


def yaml_of(channels, *more, files='"*.csv"', sampling="sampling_frequency: 1 kHz"):
    """A description of measured files: symbols or names of channels with columns, and more of its lines."""
    return "\n".join([f"files: {files}", sampling, f"channels: {{{channels}}}", *more, ""])


def columns(**units):
    """Channels of columns that have their names and these units."""
    return ", ".join(f"{name}: {{column: {name}, unit: {unit}}}" for name, unit in units.items())


USUAL = yaml_of(columns(P1="bar"))
BOTH = yaml_of(columns(P1="bar", P2="bar"))


def described(folder, description=USUAL, **texts):
    """A description in a folder, and files beside it: name, with ``_`` for the dot → text."""
    for name, text in texts.items():
        (folder / name.replace("_", ".")).write_text(text, encoding="utf-8")
    file = folder / "measured.yaml"
    file.write_text(description, encoding="utf-8")
    return file


def batches(folder, description=USUAL, **texts):
    return list(measured_source(described(folder, description, **texts)).batches(labels=True))


def one(folder, description=USUAL, **texts):
    (batch,) = batches(folder, description, **texts)
    return batch


def read(source):
    (batch,) = source.batches()
    return batch


def plain(folder, text, sampling_frequency=None):
    """A batch of a file that no description is written of."""
    (folder / "run.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return read(plain_source(folder / "run.csv", sampling_frequency))


def kinds(batch, row=0):
    return {remark.kind for remark in batch.remarks[row]}


def csv_of(*columns, sign=","):
    rows = np.column_stack([np.asarray(values, dtype=float) for _, values in columns])
    lines = [sign.join(name for name, _ in columns)]
    return "\n".join(lines + [sign.join(map(repr, row)) for row in rows.tolist()]) + "\n"


def write_hdf5(file, arrays):
    with h5py.File(file, "w") as target:
        for name, values in arrays.items():
            target[name] = values


def write_mat(file, arrays):
    nested = {}
    for name, values in arrays.items():
        *groups, last = name.split("/")
        inner = nested
        for group in groups:
            inner = inner.setdefault(group, {})
        inner[last] = values
    scipy.io.savemat(file, nested)


WRITERS = {
    "h5": write_hdf5, "mat": write_mat, "npz": lambda file, arrays: np.savez(file, **arrays),
    "parquet": lambda file, arrays: parquet.write_table(pyarrow.table(arrays), file),
}  # fmt: skip
