"""Opening a measured file by its kind."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.arrays import ArrayTable, Content, content_of, npz_table
from hydrofdi.records.measured.formats.reading_apart import table_read_apart
from hydrofdi.records.measured.formats.table import Table, damage_named
from hydrofdi.records.measured.formats.text import TextTable
from hydrofdi.settings.messages import nearest


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


_KINDS = {
    **dict.fromkeys((".csv", ".tsv", ".tab", ".txt", ".dat", ".asc"), "text"),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".nc"), "hdf5"),
    ".mat": "mat",
    **dict.fromkeys((".parquet", ".pq"), "parquet"),
    ".npz": "npz",
}
"""Suffix → kind."""


@contextmanager
def open_table(path: Path, place: str, form: FormatConfig) -> Iterator[Table]:
    """The columns of a file, to be read while it is open.

    Raises
    ------
    DataError
        The kind of file is unknown, or it is not as described.
    RejectionError
        It cannot be read.
    """
    kind = form.kind or kind_of(path, place)
    if kind == "text":
        yield TextTable(path, place, form)
        return
    content = content_of(path)
    match kind:
        case "parquet":
            yield parquet_table(place, content)
        case "npz":
            with npz_table(place, content) as table:
                yield table
        case _:
            with table_read_apart(place, kind.upper(), content) as table:
                yield table


def kind_of(path: Path, place: str) -> str:
    """Kind of a file by its suffix.

    Raises
    ------
    DataError
        The suffix is unknown.
    """
    suffix = Path(path.stem).suffix if path.suffix.lower() == ".gz" else path.suffix
    if suffix.lower() in _KINDS:
        return _KINDS[suffix.lower()]
    hint = nearest(suffix, list(_KINDS)) if suffix else ""
    raise DataError(
        f"{place}: unknown suffix {suffix!r}{hint}; hydrofdi reads {', '.join(_KINDS)} (or write"
        " 'format: {kind: text}' in the YAML that describes the file, docs/measured.md)"
    )
