"""Signals as files of other programs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from hydrofdi.api.arguments import names_of, path_of
from hydrofdi.api.simulated import SimulatedRecords
from hydrofdi.api.sources import Described, open_records
from hydrofdi.api.stored import rows_named
from hydrofdi.config.runs import run_identities
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Channel, RecordBatch, RecordSource, RejectedRecord
from hydrofdi.records.writing import OWN, WRITERS, selection
from hydrofdi.settings.messages import counted, nearest
from hydrofdi.store.experiment_data import StoredRecords, distinct_records
from hydrofdi.store.files import require_own, whole_file
from hydrofdi.store.names import RUN_ID, STATUS
from hydrofdi.tables.answer import Answer

_NAME = re.compile(rf"\d{{4,}}(-.*)?\.({'|'.join(WRITERS)})")
"""Names of the files of a folder."""
_SHOWN_OF_IDENTITY = 12
_LONGEST_NAME = 80

Texts = str | Sequence[str]
"""Names as a list, or in one text with commas."""


@dataclass(frozen=True, repr=False)
class Exported(Answer):
    """What `hydrofdi.export` has written. True if no record is left out.

    Attributes
    ----------
    files : list of Path
        One for each record.
    rejected : dict of str to str
        Record that is left out → why.
    """

    files: list[Path] = field(default_factory=list)
    rejected: dict[str, str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return not self.rejected

    def parts(self) -> Iterator[str]:
        """How many files were written, and records left out."""
        n_file, n_rejected = len(self.files), len(self.rejected)
        folders = ", ".join(dict.fromkeys(str(file.parent) for file in self.files))
        yield f"wrote {self.files[0]}" if n_file == 1 else f"wrote {counted(n_file, 'record')} to {folders}"
        if n_rejected:
            of = counted(n_file + n_rejected, "record")
            yield f"left out {n_rejected:,} of {of}; {self.first_rejection}"

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
    target, form, is_file = _target(path_of(path), format)
    sources = open_records(source, chosen.channels or tuple(Channel), Described(sampling_frequency))
    inputs = {each.resolve() for own in sources for each in getattr(own, "files", ())}
    earlier = () if is_file else _earlier_exports(target)
    if not overwrite:
        _require_new(target, earlier, inputs)
    done, taken = Exported(), set(inputs)
    for record in _records(sources, wanted, target, form, is_file=is_file):
        if isinstance(record, RejectedRecord):
            done.rejected[record.record_id] = record.remark.message
            continue
        batch, row, file = record
        if file.resolve() in taken:
            what = (
                "is both the input and the output" if file.resolve() in inputs else "would hold two records"
            )
            raise DataError(f"{file}: {what}; choose another name")
        taken.add(file.resolve())
        require_own(file, OWN[form], "an export in this format")
        with whole_file(file) as aside:
            WRITERS[form](aside, list(chosen.columns(batch, row)))
        done.files.append(file)
    for file in earlier if done.files else ():
        if file.resolve() not in taken:
            file.unlink()
    if not done.files:
        names = ", ".join(each.name for each in sources)
        raise DataError(
            f"{names}: no record could be exported{'; ' * bool(done.rejected)}{done.first_rejection}"
        )
    return done


def _texts(name: str, given: Texts | Sequence[int] | int | None) -> list[str]:
    """Names, given as a list or in one text with commas; none if nothing is given."""
    if given is None:
        return []
    texts = names_of(name, given, "names, or one text with commas")
    found = [each.strip() for text in texts for each in text.split(",") if each.strip()]
    if not found:
        raise ConfigError(f"{name}: is empty; leave it out for all")
    return found


def _target(path: Path, form: str | None) -> tuple[Path, str, bool]:
    """Path, form, and whether it is one file: it is where the path has the suffix of a form."""
    if form is not None and form not in WRITERS:
        raise ConfigError(f"format: {form!r} is unknown{nearest(str(form), [*WRITERS])}")
    suffix = path.suffix.lower().removeprefix(".")
    if path.is_file() and not suffix:
        raise DataError(f"{path}: is a file, not a folder")
    if path.is_dir() or not suffix:
        return path, form or "csv", False
    if suffix not in WRITERS:
        known = ", ".join(f".{each}" for each in WRITERS)
        raise ConfigError(f"{path}: unknown suffix '.{suffix}'; name a file {known}, or a folder")
    if form not in (None, suffix):
        raise ConfigError(f"{path}: the suffix says {suffix}, the format {form}")
    return path, suffix, True


def _earlier_exports(folder: Path) -> tuple[Path, ...]:
    """Files of a folder that have the name and the beginning of an exported file."""

    def is_own(file: Path) -> bool:
        if not _NAME.fullmatch(file.name) or not file.is_file():
            return False
        with file.open("rb") as opened:
            return OWN[file.suffix[1:]].match(opened.read(100)) is not None

    return tuple(filter(is_own, sorted(folder.iterdir()))) if folder.is_dir() else ()


def _require_new(path: Path, earlier: Sequence[Path], inputs: Collection[Path]) -> None:
    """Check that nothing has to be replaced; files do not say who wrote them."""
    if earlier:
        found = f"an earlier export ({counted(len(earlier), 'file')}, such as {earlier[0].name})"
        raise ConfigError(f"{path}: contains {found}; choose another folder, or set 'overwrite'")
    if path.is_file() and path.stat().st_size > 0 and path.resolve() not in inputs:
        raise ConfigError(
            f"{path}: already exists and was not changed; choose another name, or set 'overwrite'"
        )


def _records(
    sources: Sequence[RecordSource], runs: Sequence[str], target: Path, form: str, *, is_file: bool
) -> Iterator[tuple[RecordBatch, int, Path] | RejectedRecord]:
    """Records with the file that each of them gets; a single file has to wait for the last one."""
    held: tuple[RecordBatch, int, Path] | None = None
    for source in sources:
        chosen, names = _with_runs(source, runs)
        number = 0
        for batch in chosen.batches():
            yield from batch.rejected
            for row, record_id in enumerate(batch.record_ids):
                number += 1
                if not is_file:
                    words = re.sub(r"[^\w.]+", "-", record_id.removesuffix(f".{form}")).strip("-.")
                    usual = f"{number:04d}-{words[-_LONGEST_NAME:]}".rstrip("-")
                    yield batch, row, target / f"{names.get(record_id) or usual}.{form}"
                    continue
                if held is not None:
                    raise ConfigError(
                        f"{target}: there is more than one record (including healthy baselines); "
                        "name a folder to get one file per record, or choose one of 'runs'"
                    )
                held = batch.rows([row]), 0, target
    if held is not None:
        yield held


def _with_runs(source: RecordSource, wanted: Sequence[str]) -> tuple[RecordSource, dict[str, str]]:
    """A source that has some of its runs, by position, range or identity, and the names of their files."""
    if isinstance(source, StoredRecords):
        run_ids = [*map(str, source.data.columns[RUN_ID])]
        are_ok = [status == "ok" for status in source.data.columns[STATUS]]
    elif isinstance(source, SimulatedRecords):
        run_ids, are_ok = [*run_identities(source.runs)], [True] * len(source.runs)
    elif wanted:
        raise ConfigError(f"{source.name}: contains measured records, so there are no runs to choose")
    else:
        return source, {}
    record_ids = source.record_ids
    rows = {row for each in wanted for row in rows_named(each, run_ids, record_ids, source.name)}
    only = sorted(rows) if wanted else None
    shown = distinct_records(record_ids, are_ok, only)
    names = {record_ids[row]: f"{row:04d}-{run_ids[row][:_SHOWN_OF_IDENTITY]}" for row in shown}
    return replace(source, only=only), names
