"""A record as CSV, Parquet or MAT. Numbers are stored exactly."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.written.columns import Column
from hydrofdi.settings.counting import counted

_ROWS_AT_ONCE = 100_000


def write_csv(path: Path, columns: Sequence[Column]) -> None:
    """Rows under a header such as ``time [s],P1 [Pa]``; a missing number is an empty field."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write(",".join(column.title for column in columns) + "\n")
        for first in range(0, columns[0].values.size, _ROWS_AT_ONCE):
            parts = (column.values[first : first + _ROWS_AT_ONCE].tolist() for column in columns)
            file.writelines(",".join(map(_text, row)) + "\n" for row in zip(*parts, strict=True))


def write_parquet(path: Path, columns: Sequence[Column]) -> None:
    """Columns named as in CSV; their units are also metadata ``units`` of the fields.

    Raises
    ------
    DataError
        pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise DataError("Parquet needs the extra 'parquet': pip install 'hydrofdi[parquet]'") from None
    fields = [
        pyarrow.field(column.title, pyarrow.float64(), metadata={"units": column.unit}) for column in columns
    ]
    arrays = [pyarrow.array(column.values) for column in columns]
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), path)


def write_mat(path: Path, columns: Sequence[Column]) -> None:
    """Column vectors ``time``, ``P1``, … and a structure ``units`` with the unit of each; MAT version 5.

    Raises
    ------
    DataError
        The record is too long for such a file.
    """
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    content: dict[str, Any] = {column.name: np.ascontiguousarray(column.values) for column in columns}
    units = {column.name: column.unit for column in columns}
    try:
        savemat(str(path), content | {"units": units}, appendmat=False, oned_as="column", do_compression=True)
    except MatWriteError:
        raise DataError(
            f"{counted(columns[0].values.size, 'sample')} are too many for MAT; write Parquet"
        ) from None


WRITERS = {"csv": write_csv, "parquet": write_parquet, "mat": write_mat}
"""Form, which is also the suffix → its writer."""

OWN = {
    "csv": re.compile(rb"time \[s\],"),
    "parquet": re.compile(rb"PAR1"),
    "mat": re.compile(rb"MATLAB 5\.0 MAT-file"),
}
"""Form → first bytes of its files."""


def _text(value: float) -> str:
    return "" if value != value else repr(value)
