"""Signals as files of other programs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from hydrofdi.api.arguments import names_of, path_of
from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.api.stored import rows_identified
from hydrofdi.config import expand_runs
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Channel, RecordBatch, RecordSource, RejectedRecord
from hydrofdi.records.measured.source import MeasuredSource
from hydrofdi.records.writing import OWN, WRITERS, Selection, selection
from hydrofdi.settings.counting import counted
from hydrofdi.settings.messages import Guessable, nearest
from hydrofdi.simulation import record_identities, run_identities
from hydrofdi.store.files import require_own, whole_file
from hydrofdi.store.layout.names import RUN_ID, STATUS
from hydrofdi.store.records import StoredRecords, distinct_records

_NAME = re.compile(rf"\d{{4,}}(-.*)?\.({'|'.join(WRITERS)})")
"""Names of the files of a folder, as `_file_name` makes them."""
_RANGE = re.compile(r"(\d+)-(\d+)")
_SHOWN_OF_IDENTITY = 12
_LONGEST_NAME = 80

Texts = str | Sequence[str]
"""Names as a list, or in one text with commas."""


@dataclass(frozen=True, repr=False)
class Exported(Guessable):
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
    sources = sources_of(source, chosen.channels or tuple(Channel), Said(sampling_frequency))
    done = Exported()
    for each in exported(sources, target, chosen, wanted, overwrite=overwrite):
        if isinstance(each, RejectedRecord):
            done.rejected[each.record_id] = each.remark.message
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


@dataclass(frozen=True)
class Target:
    """Where records go: the file of one record, or a folder with a file for each."""

    path: Path
    form: str
    is_file: bool


def target_of(path: Path, form: str | None) -> Target:
    """What a path means: a file where it has the suffix of a form, a folder otherwise."""
    if form is not None and form not in [*WRITERS]:
        raise ConfigError(f"format: {form!r} is unknown{nearest(str(form), [*WRITERS])}")
    suffix = path.suffix.lower().removeprefix(".")
    if path.is_file() and not suffix:
        raise DataError(f"{path}: is a file, not a folder")
    if path.is_dir() or not suffix:
        return Target(path, form or "csv", is_file=False)
    if suffix not in WRITERS:
        known = ", ".join(f".{each}" for each in WRITERS)
        raise ConfigError(f"{path}: unknown suffix '.{suffix}'; name a file {known}, or a folder")
    if form not in (None, suffix):
        raise ConfigError(f"{path}: the suffix says {suffix}, the format {form}")
    return Target(path, suffix, is_file=True)


def exported(
    sources: Sequence[RecordSource],
    target: Target,
    selection: Selection,
    runs: Sequence[str] = (),
    *,
    overwrite: bool = False,
) -> Iterator[Path | RejectedRecord]:
    """Write records one by one; yields each file, and the records that are left out."""
    inputs = {path.resolve() for source in sources for path in _files_of(source)}
    taken = set(inputs)
    earlier = () if target.is_file else earlier_exports(target.path)
    if not overwrite:
        _require_new(target, earlier, inputs)
    n_written = 0
    for record in _records(sources, target, runs):
        if isinstance(record, RejectedRecord):
            yield record
            continue
        batch, row, file = record
        if file.resolve() in inputs:
            raise DataError(f"{file}: is both the input and the output; choose another name")
        if file.resolve() in taken:
            raise DataError(
                f"{file}: would hold more than one of these records; choose another folder or name"
            )
        taken.add(file.resolve())
        require_own(file, OWN[target.form], "an export in this format")
        with whole_file(file) as aside:
            WRITERS[target.form](aside, list(selection.columns(batch, row)))
        n_written += 1
        yield file
    for file in earlier if n_written else ():
        if file.resolve() not in taken:
            file.unlink()


def earlier_exports(folder: Path) -> tuple[Path, ...]:
    """Files of a folder that have the name and the beginning of an exported file."""
    if not folder.is_dir():
        return ()
    named = [file for file in sorted(folder.iterdir()) if _NAME.fullmatch(file.name) and file.is_file()]
    return tuple(file for file in named if _begins(file, file.suffix[1:]))


def _require_new(target: Target, earlier: Sequence[Path], inputs: Collection[Path]) -> None:
    """Check that nothing has to be replaced; files do not say who wrote them."""
    path = target.path
    if earlier:
        files = f"{len(earlier):,} files, such as {earlier[0].name}" if len(earlier) > 1 else earlier[0].name
        raise ConfigError(
            f"{path}: contains an earlier export ({files}); choose another folder, or set 'overwrite'"
        )
    is_written = target.is_file and path.is_file() and path.stat().st_size > 0
    if is_written and path.resolve() not in inputs:
        raise ConfigError(
            f"{path}: already exists and was not changed; choose another name, or set 'overwrite'"
        )


def _begins(path: Path, form: str) -> bool:
    with path.open("rb") as file:
        return OWN[form].match(file.read(100)) is not None


def _records(
    sources: Sequence[RecordSource], target: Target, runs: Sequence[str]
) -> Iterator[tuple[RecordBatch, int, Path] | RejectedRecord]:
    """Records with the file that each of them gets; a single file has to wait for the last one."""
    held: tuple[RecordBatch, int, Path] | None = None
    for source in sources:
        chosen, names = with_runs(source, runs)
        number = 0
        for batch in chosen.batches():
            yield from batch.rejected
            for row, record_id in enumerate(batch.record_ids):
                number += 1
                if not target.is_file:
                    yield batch, row, target.path / f"{_file_name(names, record_id, number)}.{target.form}"
                    continue
                if held is not None:
                    raise ConfigError(
                        f"{target.path}: there is more than one record (including healthy baselines); "
                        "name a folder to get one file per record, or choose one of 'runs'"
                    )
                held = batch.rows([row]), 0, target.path
    if held is not None:
        yield held


def _files_of(source: RecordSource) -> Collection[Path]:
    return source.files if isinstance(source, MeasuredSource) else ()


def _file_name(names: dict[str, str], record_id: str, number: int) -> str:
    """Such as ``0007-5d4aa0c0f0a1`` of a run, and ``0001-day-1-stroke`` of the first measured record."""
    words = re.sub(r"[^\w.]+", "-", record_id).strip("-.")
    return names.get(record_id) or f"{number:04d}-{words[-_LONGEST_NAME:]}".rstrip("-")


def with_runs(source: RecordSource, wanted: Sequence[str]) -> tuple[RecordSource, dict[str, str]]:
    """A source that has some of its runs, by position, range or identity, and the names of their files."""
    if isinstance(source, StoredRecords):
        run_ids = [str(run_id) for run_id in source.data.columns[RUN_ID]]
        record_ids, are_ok = source.record_ids, [status == "ok" for status in source.data.columns[STATUS]]
    elif isinstance(source, SimulatedRecords):
        runs = expand_runs(source.experiment).runs
        run_ids, record_ids, are_ok = (
            list(run_identities(runs)),
            list(record_identities(runs)),
            [True] * len(runs),
        )
    elif wanted:
        raise ConfigError(f"{source.name}: contains measured records, so there are no runs to choose")
    else:
        return source, {}
    only = _positions(run_ids, record_ids, wanted, source.name)
    shown = distinct_records(record_ids, are_ok, only)
    names = {record_ids[row]: f"{row:04d}-{run_ids[row][:_SHOWN_OF_IDENTITY]}" for row in shown}
    return replace(source, only=only), names


def _positions(
    run_ids: Sequence[str], record_ids: Sequence[str], wanted: Iterable[str], name: str
) -> Collection[int] | None:
    chosen = [position for each in wanted for position in _matching(run_ids, record_ids, each, name)]
    return sorted(set(chosen)) if chosen else None


def _matching(run_ids: Sequence[str], record_ids: Sequence[str], wanted: str, name: str) -> Collection[int]:
    if wanted.isdecimal() and int(wanted) < len(run_ids):
        return [int(wanted)]
    match = _RANGE.fullmatch(wanted)
    if match and int(match[1]) > int(match[2]):
        raise ConfigError(f"{name}: the range {wanted} runs backwards; write {match[2]}-{match[1]}")
    if match and int(match[1]) <= int(match[2]) < len(run_ids):
        return range(int(match[1]), int(match[2]) + 1)
    found = rows_identified(wanted, run_ids, record_ids)
    if len(found) != 1:
        how_many = counted(len(found), "run") if found else "no run"
        raise ConfigError(
            f"{name}: has {how_many} with the identity {wanted!r}; positions go from 0 to {len(run_ids) - 1}"
        )
    return found
