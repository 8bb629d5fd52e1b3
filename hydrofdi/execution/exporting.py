"""Files of exported records: their names, what they may replace, and what was written."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from hydrofdi.config.runs import run_identities
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import RecordBatch, RecordSource, RejectedRecord
from hydrofdi.records.files import OWN, WRITERS, Selection
from hydrofdi.settings.messages import counted, nearest
from hydrofdi.store.experiment_data import StoredRecords, distinct_records
from hydrofdi.store.files import require_own, whole_file
from hydrofdi.store.names import RUN_ID, STATUS
from hydrofdi.store.results import rows_named
from hydrofdi.tables.answer import Answer

_NAME = re.compile(rf"\d{{4,}}(-.*)?\.({'|'.join(WRITERS)})")
"""Names of the files of a folder."""


_LONGEST_NAME = 80


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


def write_records(
    sources: Sequence[RecordSource],
    runs: Sequence[str],
    chosen: Selection,
    to: tuple[Path, str, bool],
    *,
    overwrite: bool,
) -> Exported:
    """Write records, or some runs of simulated ones, to what `target_of` states."""
    target, form, is_file = to
    inputs = {each.resolve() for own in sources for each in getattr(own, "files", ())}
    earlier = () if is_file else _earlier_exports(target)
    if not overwrite:
        _require_new(target, earlier, inputs)
    done, taken = Exported(), set(inputs)
    for record in _records(sources, runs, target, form, is_file=is_file):
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


def target_of(path: Path, form: str | None) -> tuple[Path, str, bool]:
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


_SHOWN_OF_IDENTITY = 12


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
    runs, chosen = getattr(source, "runs", None), cast(Any, source)
    if isinstance(source, StoredRecords):
        run_ids = [*map(str, source.data.columns[RUN_ID])]
        are_ok = [status == "ok" for status in source.data.columns[STATUS]]
    elif runs is not None:
        run_ids, are_ok = [*run_identities(runs)], [True] * len(runs)
    elif wanted:
        raise ConfigError(f"{source.name}: contains measured records, so there are no runs to choose")
    else:
        return source, {}
    record_ids = chosen.record_ids
    rows = {row for each in wanted for row in rows_named(each, run_ids, record_ids, source.name)}
    only = sorted(rows) if wanted else None
    shown = distinct_records(record_ids, are_ok, only)
    names = {record_ids[row]: f"{row:04d}-{run_ids[row][:_SHOWN_OF_IDENTITY]}" for row in shown}
    return replace(chosen, only=only), names
