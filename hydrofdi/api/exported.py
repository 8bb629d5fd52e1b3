"""Each record as a file."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from hydrofdi.api.export_names import with_runs
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import RecordBatch, RecordSource, RejectedRecord
from hydrofdi.records.measured.source import MeasuredSource
from hydrofdi.records.written.columns import Selection
from hydrofdi.records.written.forms import OWN, WRITERS
from hydrofdi.settings.messages import nearest
from hydrofdi.store.files import require_own, whole_file

_NAME = re.compile(rf"\d{{4,}}(-.*)?\.({'|'.join(WRITERS)})")
"""Names of the files of a folder, as `RecordNames` makes them."""


@dataclass(frozen=True)
class Target:
    """Where records go.

    Attributes
    ----------
    path : Path
    form : str
        ``csv``, ``parquet`` or ``mat``.
    is_file : bool
        Whether it is the file of one record; a folder with a file for each otherwise.
    """

    path: Path
    form: str
    is_file: bool


def target_of(path: Path, form: str | None) -> Target:
    """What a path means: a file where it has the suffix of a form, a folder otherwise.

    Raises
    ------
    ConfigError
        The form is unknown, or not that of the suffix.
    """
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
    """Write records one by one; yields each file, and the records that are left out.

    Parameters
    ----------
    sources : sequence of RecordSource
    target : Target
    selection : Selection
    runs : sequence of str
        Positions, ranges, or beginnings of identities of simulated runs; empty: all records.
    overwrite : bool
        Whether an earlier export, a file or those of a folder, is replaced.

    Raises
    ------
    ConfigError
        There is no such run, a file was asked for and there is more than one record, or there is an earlier
        export that must not be replaced.
    DataError
        A record lacks a channel, or would replace its own source or another record.
    StoreError
        A file of something else would be replaced, or a file cannot be written.
    """
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
                    yield batch, row, target.path / f"{names.name(record_id, number)}.{target.form}"
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
