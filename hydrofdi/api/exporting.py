"""Signals as files of other programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from hydrofdi.api.arguments import names_of
from hydrofdi.api.places import path_of
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Channel
from hydrofdi.settings.counting import counted

Texts = str | Sequence[str]
"""Names as a list, or in one text with commas."""


@dataclass(frozen=True, repr=False)
class Exported:
    """What `hydrofdi.export` has written.

    Attributes
    ----------
    files : list of Path
        One for each record.
    rejected : dict of str to str
        Record that is left out → why.
    """

    files: list[Path] = field(default_factory=list)
    rejected: dict[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        folders = dict.fromkeys(str(file.parent) for file in self.files)
        left_out = f"; left out: {counted(len(self.rejected), 'record')}" if self.rejected else ""
        return f"{counted(len(self.files), 'file')} in {', '.join(folders) or 'no folder'}{left_out}"

    @property
    def first_rejection(self) -> str:
        """One of them as a sentence; empty if there is none."""
        return next((f"{record_id}: {reason}" for record_id, reason in self.rejected.items()), "")


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
        Of files in a folder; CSV by default.
    channels : str or sequence of str, optional
        Such as ``"P1,P2,x"``; all by default.
    unit : str or sequence of str, optional
        Such as ``"bar,mm"``: each for the channels that it fits. The others are in SI.
    runs : str, int or sequence of them, optional
        Of simulated runs: positions, ranges ``"3-9"``, beginnings of identities; all by default.
    sampling_frequency : str or float, optional
        Of a data file without a column of time [Hz].
    overwrite : bool
        Whether an existing file, or the files of an earlier export in the folder, are replaced.

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
    from hydrofdi.api.exported import exported, target_of
    from hydrofdi.records import RejectedRecord
    from hydrofdi.records.written.columns import selection

    chosen = selection(_texts("channels", channels), _texts("unit", unit))
    wanted = _texts("runs", runs)
    target = target_of(path_of(path), format)
    sources = sources_of(source, chosen.channels or tuple(Channel), Said(sampling_frequency))
    done = Exported()
    for each in exported(sources, target, chosen, wanted, overwrite=overwrite):
        if isinstance(each, RejectedRecord):
            done.rejected[each.record_id] = each.remark.text
        else:
            done.files.append(each)
    if not done.files:
        names = ", ".join(each.name for each in sources)
        raise DataError(
            f"{names}: no record could be exported{'; ' * bool(done.rejected)}{done.first_rejection}"
        )
    return done


def _texts(name: str, given: Texts | Sequence[int] | int | None) -> list[str]:
    """Names, given as a list or in one text with commas; none if nothing is given.

    Raises
    ------
    ConfigError
        The selection is empty, or contains something other than names.
    """
    if given is None:
        return []
    texts = names_of(name, given, "names, or one text with commas")
    found = [each.strip() for text in texts for each in text.split(",") if each.strip()]
    if not found:
        raise ConfigError(f"{name}: is empty; leave it out for all")
    return found
