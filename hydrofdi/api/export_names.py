"""Runs by their positions and identities, and the names that their files get from these."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.api.stored import rows_identified
from hydrofdi.config import expand_runs
from hydrofdi.errors import ConfigError
from hydrofdi.records import RecordSource
from hydrofdi.settings.counting import counted
from hydrofdi.simulation import record_identities, run_identities
from hydrofdi.store.layout.names import RUN_ID, STATUS
from hydrofdi.store.records import StoredRecords, distinct_records

_RANGE = re.compile(r"(\d+)-(\d+)")
_SHOWN_OF_IDENTITY = 12
_LONGEST_NAME = 80


@dataclass(frozen=True)
class RecordNames:
    """Names of the records of a source as parts of file names.

    Attributes
    ----------
    of_run : dict of str to str
        Record id of a run → its position and the beginning of its identity; empty for other records.
    """

    of_run: dict[str, str]

    def name(self, record_id: str, number: int) -> str:
        """Such as ``0007-5d4aa0c0f0a1`` of a run, and ``0001-day-1-stroke`` of the first measured record."""
        if record_id in self.of_run:
            return self.of_run[record_id]
        words = re.sub(r"[^\w.]+", "-", record_id).strip("-.")
        return f"{number:04d}-{words[-_LONGEST_NAME:]}".rstrip("-")


def with_runs(source: RecordSource, wanted: Sequence[str]) -> tuple[RecordSource, RecordNames]:
    """A source that has some of its runs, and names for them.

    Parameters
    ----------
    source : RecordSource
    wanted : sequence of str
        Positions (``3``), ranges (``3-9``), and beginnings of identities of runs or records; empty: all.

    Raises
    ------
    ConfigError
        There is no such run, or the source has no runs.
    """
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
        return source, RecordNames({})
    only = _positions(run_ids, record_ids, wanted, source.name)
    shown = distinct_records(record_ids, are_ok, only)
    names = {record_ids[row]: f"{row:04d}-{run_ids[row][:_SHOWN_OF_IDENTITY]}" for row in shown}
    return replace(source, only=only), RecordNames(names)


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
