"""Signals as files of other programs."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal

from hydrofdi.api.sources import Described, open_records
from hydrofdi.errors import ConfigError
from hydrofdi.records import Channel
from hydrofdi.records.files import selection
from hydrofdi.settings.arguments import names_of, path_of
from hydrofdi.store.exporting import Exported, target_of, write_records

Texts = str | Sequence[str]
"""Names as a list, or in one text with commas."""


def export(
    source: Any,
    path: str | PathLike[str],
    *,
    format: Literal["csv", "parquet", "mat"] | None = None,
    channels: Texts | None = None,
    unit: Texts | None = None,
    runs: Texts | Sequence[int] | int | None = None,
    sampling_frequency: str | float | None = None,
    overwrite: bool = False,
) -> Exported:
    """Write signals as CSV, Parquet or MAT, as ``hydrofdi export`` does.

    Parameters
    ----------
    source : path, sequence of path, array_like, mapping, pandas.DataFrame, xarray.DataArray or xarray.Dataset
        As `hydrofdi.measure` takes it: results with signals, an experiment to be simulated, measured files.
    path : path
        A file ending in ``.csv``, ``.parquet`` or ``.mat`` for one record; otherwise a folder with a file for
        each.
    format : {"csv", "parquet", "mat"}, optional
        Format of files in a folder [default: csv].
    channels : str or sequence of str, optional
        Such as ``P1,P2,x`` [default: all].
    unit : str or sequence of str, optional
        Such as ``bar,mm``, each for the channels of its dimension; the others are in SI.
    runs : str, int or sequence of them, optional
        Simulated runs: positions, ranges such as ``3-9``, or first characters of identities [default: all].
    sampling_frequency : str or float, optional
        Of a data file without a column of time [Hz].
    overwrite : bool
        Replace an existing file, or the files of an earlier export in the folder.

    Returns
    -------
    Exported
        The files, and the records that are left out.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, the records cannot be read or written, or there are none.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.export({"P1 [bar]": [50.0, 50.5], "time [s]": [0.0, 0.01]}, "rig.csv").files[0].read_text()
    'time [s],P1 [Pa]\\n0.0,5000000.0\\n0.01,5050000.0\\n'
    """
    chosen = selection(_texts("channels", channels), _texts("unit", unit))
    wanted = _texts("runs", runs)
    target = target_of(path_of(path), format)
    sources = open_records(source, chosen.channels or tuple(Channel), Described(sampling_frequency))
    return write_records(sources, wanted, chosen, target, overwrite=overwrite)


def _texts(name: str, given: Texts | Sequence[int] | int | None) -> list[str]:
    """Names, given as a list or in one text with commas; none if nothing is given."""
    if given is None:
        return []
    texts = names_of(name, given, "names, or one text with commas")
    found = [each.strip() for text in texts for each in text.split(",") if each.strip()]
    if not found:
        raise ConfigError(f"{name}: is empty; leave it out for all")
    return found
