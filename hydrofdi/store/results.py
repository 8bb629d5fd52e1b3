"""The results of the runs of an experiment, in the order of its table, wherever they lie."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hydrofdi.store.failures import Failure
from hydrofdi.store.index import StoredRun
from hydrofdi.store.names import COMPUTED, MESSAGE, RUN_ID, STATUS, TIME, Variable
from hydrofdi.store.shard import Columns, read_variable
from hydrofdi.store.variables import absent_values, holds_variable

MISSING = "missing"
"""Status of a run that has not been computed."""


class Results(Protocol):
    """Computed variables of all runs."""

    @property
    def n_run(self) -> int:
        """Number of runs."""
        ...

    def column(self, variable: Variable) -> NDArray[Any]:
        """A variable that is no signal, one row per run."""
        ...

    def signal(self, name: str, window: slice) -> NDArray[Any]:
        """Rows of a signal, shape (n_run in the window, n_time)."""
        ...

    def time(self) -> NDArray[np.float64] | None:
        """Sampling instants [s]; None where there are no signals."""
        ...


class HeldResults:
    """Results in memory.

    Parameters
    ----------
    columns : mapping
        All computed variables.
    """

    def __init__(self, columns: Columns) -> None:
        self._columns = columns

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self._columns[RUN_ID])

    def column(self, variable: Variable) -> NDArray[Any]:
        """A variable that is no signal, one row per run."""
        return self._columns[variable.name]

    def signal(self, name: str, window: slice) -> NDArray[Any]:
        """Rows of a signal."""
        return self._columns[name][window]

    def time(self) -> NDArray[np.float64] | None:
        """Sampling instants [s]."""
        return self._columns[TIME]


class ShardResults:
    """Results that lie in shards, with holes where runs failed or are missing.

    Parameters
    ----------
    run_ids : sequence of str
        The runs in their order.
    stored : mapping
        Identity → where a run lies.
    failures : mapping
        Identity → why a run has no result.
    """

    def __init__(
        self, run_ids: Sequence[str], stored: dict[str, StoredRun], failures: dict[str, Failure]
    ) -> None:
        self._run_ids = run_ids
        self._failures = failures
        self._located = [stored.get(run_id) for run_id in run_ids]
        self._any_shard = next((run.shard for run in self._located if run is not None), None)

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self._run_ids)

    def column(self, variable: Variable) -> NDArray[Any]:
        """A variable that is no signal; NaN, or the reason, where a run has no result."""
        if variable.name == RUN_ID:
            return np.array(self._run_ids, dtype=object)
        if variable.name == STATUS:
            return np.array([self._reason(position)[0] for position in range(self.n_run)], dtype=object)
        column = self._gathered(variable.name, slice(0, self.n_run))
        if variable.name == MESSAGE:
            for position in range(self.n_run):
                if self._located[position] is None:
                    column[position] = self._reason(position)[1]
        return column

    def signal(self, name: str, window: slice) -> NDArray[Any]:
        """Rows of a signal; NaN where a run has no result."""
        return self._gathered(name, window)

    def time(self) -> NDArray[np.float64] | None:
        """Sampling instants [s]; None where no run is stored with signals."""
        shard = next((run.shard for run in self._located if run is not None and run.signals != "none"), None)
        return None if shard is None else _whole_variable(shard, TIME)

    def _reason(self, position: int) -> tuple[str, str]:
        located = self._located[position]
        if located is not None:
            return located.status, ""
        failure = self._failures.get(self._run_ids[position])
        return (failure.status, failure.message) if failure else (MISSING, "not computed yet")

    def _gathered(self, name: str, window: slice) -> NDArray[Any]:
        by_shard: dict[Path, list[int]] = {}
        for position in range(window.start, window.stop):
            located = self._located[position]
            if located is not None:
                by_shard.setdefault(located.shard, []).append(position)
        column: NDArray[Any] = np.full((window.stop - window.start, 0), np.nan)
        for shard, positions in by_shard.items():
            rows = np.array([self._row(position) for position in positions])
            values = read_variable(shard, name, rows)
            column = _room_for(values, column)
            inside = tuple(slice(size) for size in values.shape[1:])
            column[(np.array(positions) - window.start, *inside)] = values
        return column if by_shard else self._empty(name, window.stop - window.start)

    def _row(self, position: int) -> int:
        located = self._located[position]
        assert located is not None
        return located.row

    def _empty(self, name: str, n_run: int) -> NDArray[Any]:
        """Rows of a variable of which no run of a window has any."""
        if name == MESSAGE:
            return np.full(n_run, "", dtype=object)
        if self._any_shard is None:
            two_dimensional = any(
                variable.name == name and len(variable.dimensions) > 1 for variable in COMPUTED
            )
            return np.full((n_run, 0) if two_dimensional else n_run, np.nan)
        like = _whole_variable(self._any_shard, name)
        return np.full((n_run, *like.shape[1:]), np.nan, dtype=like.dtype)


def _whole_variable(shard: Path, name: str) -> NDArray[Any]:
    from hydrofdi.store.files import open_for_reading

    with open_for_reading(shard) as file:
        if not holds_variable(file, name):
            return absent_values(file, name)
        return np.asarray(file[name][:])


def _room_for(values: NDArray[Any], column: NDArray[Any]) -> NDArray[Any]:
    """A column that values fit into, with what it held."""
    n_run = column.shape[0]
    if values.dtype == object:
        return column if column.dtype == object else np.full(n_run, "", dtype=object)
    if values.ndim != column.ndim:
        return np.full((n_run, *values.shape[1:]), np.nan)
    shape = tuple(map(max, column.shape[1:], values.shape[1:]))
    if shape == column.shape[1:]:
        return column
    wider = np.full((n_run, *shape), np.nan, dtype=values.dtype)
    wider[(slice(None), *(slice(size) for size in column.shape[1:]))] = column
    return wider
