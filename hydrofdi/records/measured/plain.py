"""Measured files without a description: their headers must name channels and units."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hydrofdi.errors import DataError
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.records.measured.files import in_natural_order
from hydrofdi.records.measured.headers import completed
from hydrofdi.records.measured.source import MeasuredSource
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Source

_SUFFIXES_IN_FOLDERS = (".csv", ".tsv", ".parquet", ".pq", ".mat", ".npz", ".csv.gz", ".tsv.gz")
"""Suffixes of records in a folder; a text such as readme.txt may be anything."""


def plain_file_source(path: Path | str, sampling_frequency: float | None = None) -> MeasuredSource:
    """The record of one file whose headers name channels and units.

    Parameters
    ----------
    path : path
    sampling_frequency : float, optional
        [Hz]; needed if the file has no column ``time [s]``.

    Raises
    ------
    DataError
        The headers are not sufficient; the message shows the description to write.
    """
    file = Path(path)
    if not file.is_file():
        raise DataError(f"{file}: {'is a folder' if file.is_dir() else 'no such file'}")
    return _plain_source(str(path), file.parent, [file], sampling_frequency)


def plain_files(folder: Path) -> list[Path]:
    """The files of a folder that are read as records, in natural order."""
    return in_natural_order(
        [
            file
            for file in folder.iterdir()
            if file.is_file() and file.name[0] != "." and file.name.lower().endswith(_SUFFIXES_IN_FOLDERS)
        ]
    )


def plain_folder_source(folder: Path, sampling_frequency: float | None = None) -> MeasuredSource | None:
    """The records of the files in a folder, all with the columns of the first; None if there are none.

    Parameters
    ----------
    folder : path
        Its subfolders and hidden files are not read.
    sampling_frequency : float, optional
        [Hz]; needed if the files have no column ``time [s]``.

    Raises
    ------
    DataError
        The headers of the first file are not sufficient.
    """
    files = plain_files(folder)
    return _plain_source(str(folder), folder, files, sampling_frequency) if files else None


def _plain_source(
    name: str, folder: Path, files: Sequence[Path], sampling_frequency: float | None
) -> MeasuredSource:
    sampling = {} if sampling_frequency is None else {"sampling_frequency": sampling_frequency}
    named = validated(MeasuredConfig, Source({"files": [file.name for file in files]} | sampling))
    config, unused = completed(named, files, is_plain=True)
    return MeasuredSource(name, folder, config, files, unused)
