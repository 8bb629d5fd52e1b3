"""Parquet files, by the extra ``parquet``."""

from __future__ import annotations

from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.records.measured.formats.arrays import ArrayTable
from hydrofdi.records.measured.formats.content import Content
from hydrofdi.records.measured.rejection import damage_named


def parquet_table(place: str, content: Content) -> ArrayTable:
    """The columns of a file.

    Raises
    ------
    DataError
        pyarrow is not installed.
    """
    try:
        import pyarrow.parquet as parquet
    except ImportError:
        message = "Parquet needs the extra 'parquet': pip install 'hydrofdi[parquet]'"
        raise DataError(f"{place}: {message}") from None
    with damage_named("Parquet"):
        file = parquet.ParquetFile(content)
        n_row, names = file.metadata.num_rows, file.schema_arrow.names

    def load(name: str) -> Any:
        return _values(file.read(columns=[name]).column(0))

    return ArrayTable(place, "Parquet", dict.fromkeys(names, (n_row,)), load)


def _values(column: Any) -> Any:
    import pyarrow

    if pyarrow.types.is_integer(column.type) and column.null_count:
        column = column.cast(pyarrow.float64())
    return column.to_numpy()
