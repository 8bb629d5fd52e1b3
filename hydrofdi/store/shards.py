"""Shards: the results of one batch of runs, written atomically and named by a hash of their content.

The index of an experiment's shards says where each run is; it is rebuilt from new and changed shards.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import StoreConfig
from hydrofdi.config.runs import PHYSICS_VERSION
from hydrofdi.errors import StoreError
from hydrofdi.store import names
from hydrofdi.store.files import LIBRARY_VERSIONS, open_for_reading, whole_file, write_whole_text
from hydrofdi.store.folder import Failure
from hydrofdi.store.names import Variable

if TYPE_CHECKING:
    import h5py


def create_signal(
    file: h5py.File, name: str, shape: tuple[int, int], store: StoreConfig, still: float | None = None
) -> h5py.Dataset:
    """Create a signal of shape (n_run, n_time); rows that are constant at `still` take no space."""
    options: dict[str, Any] = {}
    if still is not None:
        options = {"chunks": (1, shape[1]), "fillvalue": still}
    if store.compression != "none":
        # A chunk is a run: reading one decompresses no other.
        options |= {"chunks": (1, shape[1]), "compression": store.compression, "shuffle": True}
    if store.compression == "gzip":
        options["compression_opts"] = 4
    return file.create_dataset(name, shape, store.dtype, **options)


def create_column(file: h5py.File, name: str, values: Any) -> h5py.Dataset:
    """Create a variable of numbers or texts with one row per run."""
    import h5py

    array = np.asarray(values)
    if array.dtype.kind not in "OU":
        return file.create_dataset(name, data=array)
    return file.create_dataset(name, data=[str(text) for text in array], dtype=h5py.string_dtype())


def write_rows(target: h5py.Dataset, first: int, rows: NDArray[Any]) -> None:
    """Write rows of a signal, but for those at the fill value, from a row on."""
    import h5py

    rows = rows.astype(target.dtype, copy=False)
    if target.id.get_create_plist().fill_value_defined() != h5py.h5d.FILL_VALUE_USER_DEFINED:
        target[first : first + len(rows)] = rows
        return
    # NaN is not equal to itself.
    stands = np.isnan(rows) if np.isnan(target.fillvalue) else rows == target.fillvalue
    for moving in np.flatnonzero(~stands.all(axis=1)):
        target[first + moving] = rows[moving]


@dataclass(frozen=True)
class FileSignals:
    """Signals in an experiment file."""

    path: Path

    def time(self) -> NDArray[np.float64] | None:
        """Sampling instants [s]; None if no signals are stored."""
        with open_for_reading(self.path) as file:
            return np.asarray(file[names.TIME][:]) if names.TIME in file else None

    def rows(self, signals: Collection[str], positions: Sequence[int]) -> dict[str, NDArray[np.float64]]:
        """Signals of some runs by name; signals that the file lacks are omitted."""
        with open_for_reading(self.path) as file:
            return {name: _signal_rows(file[name], positions) for name in signals if name in file}


def _signal_rows(signal: h5py.Dataset, rows: Sequence[int]) -> NDArray[np.float64]:
    """Rows of a signal in double precision, (n_row, n_time); a shared signal is repeated."""
    if signal.ndim == 1:
        return np.tile(np.asarray(signal[:], dtype=float), (len(rows), 1))
    first = min(rows)
    block: NDArray[np.float64] = np.asarray(signal[first : max(rows) + 1], dtype=float)
    return block if len(block) == len(rows) == 1 else np.take(block, np.asarray(rows) - first, axis=0)


Columns = Mapping[str, NDArray[Any]]
"""Variable name → array with one row per run; ``time`` → sampling instants [s]."""

SHARDS = "shards"
"""Folder of the shards within an experiment's folder."""


def write_shard(directory: Path, columns: Columns, store: StoreConfig) -> Path:
    """Write the results of a batch atomically into an experiment's folder."""
    return _place_shard(directory, lambda aside: _write_file(aside, columns, store))


def store_shard_bytes(directory: Path, content: bytes) -> Path:
    """Store the content of a shard that was made elsewhere, and return its path."""
    return _place_shard(directory, lambda aside: aside.write_bytes(content))


def _place_shard(directory: Path, write: Callable[[Path], object]) -> Path:
    path = directory / SHARDS / "new.h5"
    with whole_file(path, lambda: path) as aside:
        write(aside)
        path = path.with_name(f"{content_digest(aside)}.h5")
    return path


def _write_file(path: Path, columns: Columns, store: StoreConfig) -> None:
    import h5py

    has_phases = names.SETTLED_PHASE_DETAIL_RMS in columns
    with h5py.File(path, "w", libver=LIBRARY_VERSIONS) as file:
        file.attrs["format_version"] = names.FORMAT_VERSION
        file.attrs["physics_version"] = PHYSICS_VERSION
        file.attrs["signals"] = store.signals
        file.attrs["dtype"] = store.dtype
        outputs = [
            Variable(name, (names.RUN,), "", "")
            for name, values in columns.items()
            if "." in name and not names.is_needless(name, values)
        ]
        for variable in (*names.stored_variables(store.signals, phases=has_phases), *outputs):
            if variable.is_signal and variable.name not in columns:
                continue  # a signal that the plant does not give
            values = columns[variable.name]
            if variable.is_signal:
                still = values[0, 0] if variable.is_mostly_still else None
                write_rows(create_signal(file, variable.name, values.shape, store, still), 0, values)
            else:
                create_column(file, variable.name, values)
        if store.signals != "none":
            file.create_dataset(names.TIME, data=columns[names.TIME])


def content_digest(path: Path) -> str:
    """The first 32 hexadecimal digits of the SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def read_content(path: Path, *, check: bool = True) -> dict[str, Any]:
    """What a shard contains, as the index has it, after checking it against its name if `check` is true."""
    if check and content_digest(path) != path.stem:
        raise StoreError(f"{path}: is damaged: its content does not match its name")
    with open_for_reading(path) as file:
        if file.attrs["format_version"] != names.FORMAT_VERSION:
            raise StoreError(f"{path}: has format version {file.attrs['format_version']}")
        columns = {"run_ids": names.RUN_ID, "record_ids": names.RECORD_ID, "statuses": names.STATUS}
        return {
            **{key: values_in(file, name).tolist() for key, name in columns.items()},
            "signals": str(file.attrs["signals"]),
            "dtype": str(file.attrs["dtype"]),
            "physics_version": int(file.attrs["physics_version"]),
        }


def values_in(file: h5py.File, name: str, rows: slice = np.s_[:]) -> NDArray[Any]:
    """Rows of a variable."""
    import h5py

    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{name} is not a variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[rows] if is_text else dataset[rows])


def read_rows(path: Path, variables: Iterable[str], rows: Sequence[int]) -> dict[str, NDArray[Any]]:
    """Rows of those of some variables that a shard contains, by name."""
    first, inside = min(rows), slice(min(rows), max(rows) + 1)
    with open_for_reading(path) as file:
        return {
            name: values_in(file, name, inside)[np.asarray(rows) - first]
            for name in variables
            if name in file
        }


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


def _keep_more_complete(located: dict[str, StoredRun], identity: str, stored: StoredRun) -> None:
    known = located.setdefault(identity, stored)
    if known is not stored and _completeness(known) < _completeness(stored):
        located[identity] = stored


_DTYPES = ("float32", "float64")


def _completeness(stored: StoredRun) -> tuple[int, int]:
    return len(names.stored_signals(stored.signals)), _DTYPES.index(stored.dtype)


def holds_enough(stored: StoredRun, signals: str, dtype: str) -> bool:
    """Whether a stored run has the requested signals in at least the requested precision."""
    if signals == "none":
        return True
    has_signals = names.stored_signals(stored.signals) >= names.stored_signals(signals)
    return has_signals and _DTYPES.index(stored.dtype) >= _DTYPES.index(dtype)


def gathered(
    runs: Sequence[StoredRun | None], variables: Collection[Variable], sizes: Mapping[str, int]
) -> dict[str, NDArray[Any]]:
    """Variables of stored runs by name, one row per run, without signals that no run has; each shard is
    opened once."""
    columns = {
        variable.name: variable.blank(len(runs), *(sizes[name] for name in variable.dimensions[1:]))
        for variable in variables
    }
    positions_in: dict[Path, list[int]] = {}
    rows_in: dict[Path, list[int]] = {}
    for position, run in enumerate(runs):
        if run is not None:
            positions_in.setdefault(run.shard, []).append(position)
            rows_in.setdefault(run.shard, []).append(run.row)
    absent = {variable.name for variable in variables if variable.is_signal}
    for shard, positions in positions_in.items():
        for name, values in read_rows(shard, columns, rows_in[shard]).items():
            inside: list[Any] = [positions, *(slice(size) for size in values.shape[1:])]
            columns[name][tuple(inside)] = values
            absent.discard(name)
    return {name: values for name, values in columns.items() if name not in absent}


class ShardResults:
    """Results in shards, with gaps where runs failed or are missing."""

    def __init__(self, run_ids: Sequence[str], index: ShardIndex, failures: dict[str, Failure]) -> None:
        self._run_ids = run_ids
        self._failures = failures
        self._located = [index.runs.get(run_id) for run_id in run_ids]
        self._signals = [None if run is None else index.signals_of(run) for run in self._located]

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self._run_ids)

    def columns(self, variables: Sequence[Variable], sizes: Mapping[str, int]) -> dict[str, NDArray[Any]]:
        """Variables other than signals of these dimensions; NaN, or the reason, without a result."""
        columns = gathered(self._located, variables, sizes)
        columns[names.RUN_ID][:] = self._run_ids
        columns[names.STATUS][:] = self.statuses()
        told = [name for name in columns if name == names.MESSAGE or name.endswith(names.OBSTACLE)]
        for position, located in enumerate(self._located):
            if located is None:
                for name in told:
                    columns[name][position] = self._reason(position)[1]
        return columns

    def statuses(self) -> list[str]:
        """Status of each run, or why it has no result."""
        return [
            self._reason(position)[0] if located is None else located.status
            for position, located in enumerate(self._located)
        ]

    def rows(self, signals: Collection[str], positions: Sequence[int]) -> dict[str, NDArray[np.float64]]:
        """Signals of some runs by name; a signal that no run has is omitted, missing rows are NaN."""
        runs = [self._signals[position] for position in positions]
        stored = frozenset[str]().union(*(names.stored_signals(run.signals) for run in runs if run))
        held = [each for each in names.stored_variables("all") if each.name in stored.intersection(signals)]
        time = self.time() if held else None
        return {} if time is None else gathered(runs, held, {names.TIME: len(time)})

    def signal(self, name: str, position: int) -> NDArray[np.float64]:
        """A signal of one run; empty if it is not stored."""
        rows = self.rows([name], [position])
        return rows[name][0] if name in rows else np.empty(0)

    def time(self) -> NDArray[np.float64] | None:
        """Sampling instants [s]; None if no run is stored with signals."""
        shard = next((run.shard for run in self._signals if run is not None and run.signals != "none"), None)
        if shard is None:
            return None
        with open_for_reading(shard) as file:
            return np.asarray(file[names.TIME][:])

    def _reason(self, position: int) -> tuple[str, str]:
        """Status and message of a run without a result."""
        failure = self._failures.get(self._run_ids[position])
        return (failure.status, failure.message) if failure else (names.MISSING, "not computed yet")
