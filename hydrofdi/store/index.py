"""Index of an experiment's shards: the location of each run. It is rebuilt from new and changed shards."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.files import write_whole_text
from hydrofdi.store.layout.names import stored_signals
from hydrofdi.store.shard import SHARDS, read_content

_FILE = "index.json"
_FORMAT = 2


class StoredRun(NamedTuple):
    """Location and kind of the results of a run; a tuple to save memory."""

    shard: Path
    row: int
    status: str
    signals: str
    dtype: str
    record_id: str


class ShardIndex:
    """All shards in an experiment's folder.

    Attributes
    ----------
    runs, records : dict
        Identity of a run, or of a record → where most of its signals are stored.
    damaged : dict
        Damaged shard → description of the damage.
    lost : set of str
        Runs that the index lists in shards that are damaged or missing.
    """

    def __init__(
        self, directory: Path, entries: dict[str, dict[str, Any]], damaged: dict[Path, str], lost: set[str]
    ) -> None:
        self._directory = directory
        self._entries = entries
        self.damaged = damaged
        self.runs: dict[str, StoredRun] = {}
        self.records: dict[str, StoredRun] = {}
        self.physics_versions: set[int] = set()
        for name in sorted(entries):
            self._add(directory / SHARDS / name, entries[name])
        self.lost = lost - self.runs.keys()

    def _add(self, shard: Path, entry: dict[str, Any]) -> None:
        signals, dtype = entry["signals"], entry["dtype"]
        self.physics_versions.add(entry["physics_version"])
        columns = zip(entry["run_ids"], entry["record_ids"], entry["statuses"], strict=True)
        for row, (run_id, record_id, status) in enumerate(columns):
            stored = StoredRun(shard, row, status, signals, dtype, record_id)
            _keep_more_complete(self.runs, run_id, stored)
            if record_id:
                _keep_more_complete(self.records, record_id, stored)

    @property
    def n_run_of_earlier_physics(self) -> int:
        """Number of runs in shards of earlier physics versions."""
        earlier = (entry for entry in self._entries.values() if entry["physics_version"] < PHYSICS_VERSION)
        return sum(len(entry["run_ids"]) for entry in earlier)

    def signals_of(self, run: StoredRun) -> StoredRun:
        """Location of the signals of a run's record: its own shard, or one that stores more signals."""
        record = self.records.get(run.record_id, run)
        return record if _completeness(record) > _completeness(run) else run

    def save(self) -> None:
        """Save the index, so that unchanged shards need not be read again."""
        write_whole_text(
            self._directory / _FILE,
            json.dumps({"format": _FORMAT, "shards": self._entries}, separators=(",", ":")),
        )


def read_index(
    directory: Path, *, trust: bool = True, check: bool = True, fresh: frozenset[str] = frozenset()
) -> ShardIndex:
    """Read the index of the shards in a folder, and check those that are neither known nor fresh."""
    remembered = _from_index(directory / _FILE)
    entries: dict[str, dict[str, Any]] = {}
    damaged: dict[Path, str] = {}
    for path in sorted((directory / SHARDS).glob("*.h5")):
        if path.name.startswith("."):
            continue
        stat = path.stat()
        mark = {"size": stat.st_size, "mtime_ns": stat.st_mtime_ns}
        known = remembered.get(path.name, {})
        if trust and known.items() >= mark.items():
            entries[path.name] = known
            continue
        try:
            entries[path.name] = read_content(path, check=check and path.name not in fresh) | mark
        except StoreError as error:
            damaged[path] = str(error)
    lost = {run_id for name in remembered.keys() - entries.keys() for run_id in remembered[name]["run_ids"]}
    return ShardIndex(directory, entries, damaged, lost)


def _from_index(path: Path) -> dict[str, Any]:
    try:
        index = json.loads(path.read_text())
        return dict(index["shards"]) if index["format"] == _FORMAT else {}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def _keep_more_complete(places: dict[str, StoredRun], identity: str, stored: StoredRun) -> None:
    known = places.setdefault(identity, stored)
    if known is not stored and _completeness(known) < _completeness(stored):
        places[identity] = stored


_DTYPES = ("float32", "float64")


def _completeness(stored: StoredRun) -> tuple[int, int]:
    return len(stored_signals(stored.signals)), _DTYPES.index(stored.dtype)


def holds_enough(stored: StoredRun, signals: str, dtype: str) -> bool:
    """Whether a stored run has the requested signals in at least the requested precision."""
    if signals == "none":
        return True
    has_signals = stored_signals(stored.signals) >= stored_signals(signals)
    return has_signals and _DTYPES.index(stored.dtype) >= _DTYPES.index(dtype)
