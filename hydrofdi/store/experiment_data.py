"""Results of runs in the order of their table, and an experiment as it was stored."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.experiment import DWT, Indicators
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store import names, shards
from hydrofdi.store.files import open_for_reading
from hydrofdi.store.folder import Failure
from hydrofdi.store.names import Variable

if TYPE_CHECKING:
    pass

MISSING = "missing"
"""Status of a run that has not been computed."""


def gathered(
    runs: Sequence[shards.StoredRun | None], variables: Collection[Variable], sizes: Mapping[str, int]
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
        for name, values in shards.read_rows(shard, columns, rows_in[shard]).items():
            inside: list[Any] = [positions, *(slice(size) for size in values.shape[1:])]
            columns[name][tuple(inside)] = values
            absent.discard(name)
    return {name: values for name, values in columns.items() if name not in absent}


class ShardResults:
    """Results in shards, with gaps where runs failed or are missing."""

    def __init__(
        self, run_ids: Sequence[str], index: shards.ShardIndex, failures: dict[str, Failure]
    ) -> None:
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
        return (failure.status, failure.message) if failure else (MISSING, "not computed yet")


@dataclass(frozen=True)
class ExperimentData:
    """An experiment and its results: variable → array with one row per run, and where its signals are.

    `configuration` is what the file says, in SI; None if there is no file. `remarks` apply to all rows.
    `absent`: label of an indicator that is not installed → what the file says of it.
    """

    path: Path
    experiment: ExperimentConfig
    columns: dict[str, NDArray[Any]]
    versions: dict[str, str]
    signals: shards.FileSignals | ShardResults
    configuration: dict[str, Any] | None = None
    remarks: tuple[str, ...] = ()
    physics_version: int = PHYSICS_VERSION
    absent: Indicators = field(default_factory=dict)

    @property
    def all_remarks(self) -> tuple[str, ...]:
        """The remarks, and that another version of the physics computed the runs."""
        older = (
            f"Computed with version {self.physics_version} of the physics; this hydrofdi has version"
            f" {PHYSICS_VERSION}, and runs that are computed now may differ."
        )
        return (*self.remarks, *([older] if self.physics_version != PHYSICS_VERSION else []))

    @property
    def indicators(self) -> Indicators:
        """Label → indicator."""
        return {**self.experiment.indicator_choice.made(self.experiment.wavelet), **self.absent}

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self.columns[names.RUN_ID])

    @property
    def is_whole(self) -> bool:
        """Whether every run has been computed or has failed."""
        return MISSING not in self.columns[names.STATUS]

    @cached_property
    def leakage_requests(self) -> NDArray[np.float64]:
        """Requested leakage of each run: mean flow [m³/s] or K_i [m^3.5/kg^0.5]; 0 if sealed."""
        level = self.columns[names.LEAKAGE_LEVEL]
        requests: NDArray[np.float64] = np.where(
            np.isnan(level), self.columns[names.LEAKAGE_COEFFICIENT], level
        )
        return requests

    @cached_property
    def fixed_baseline(self) -> NDArray[np.int64]:
        """Row of each run's sealed run under the baseline's conditions; `NO_BASELINE` if there is none."""
        return self._sealed(self.columns[names.FIXED_BASELINE])

    @cached_property
    def matched_baseline(self) -> NDArray[np.int64]:
        """Row of each run's sealed run under its own conditions; `NO_BASELINE` if there is none."""
        return self._sealed(self.columns[names.MATCHED_BASELINE])

    @property
    def baselines(self) -> dict[str, NDArray[np.int64]]:
        """Rows of the healthy runs by the names of both kinds: ``fixed`` and ``matched``."""
        return {"fixed": self.fixed_baseline, "matched": self.matched_baseline}

    @property
    def has_details(self) -> bool:
        """Whether the experiment measures the wavelet details as configured."""
        return DWT in self.experiment.indicators

    def _sealed(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Baseline rows, without those of leaking runs."""
        return np.where((rows >= 0) & (self.leakage_requests[rows] == 0.0), rows, names.NO_BASELINE)

    def values(self, name: str) -> list[Any]:
        """Value of a dotted parameter in SI, for each run; None if it is not set."""
        variable = names.axis_variable(name)
        if variable in self.columns:
            stored = self.columns[variable].tolist()
            return [None if value != value or value == "" else value for value in stored]
        values = np.full(self.n_run, self.experiment.nominal_parameters.shown_value(name), dtype=object)
        if name in self.experiment.baseline:
            of_baseline = [names.FIXED_BASELINE] + [names.MATCHED_BASELINE] * name.startswith("leakage.")
            for rows in (self.columns[kind] for kind in of_baseline):
                values[rows[rows >= 0]] = self.experiment.baseline[name]
        return list(values)

    def signal(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run, (n_time,); a StoreError if it is not stored."""
        time, rows = self.signals.time(), self.signals.rows([name], [position])
        if time is None or name not in rows:
            raise StoreError(f"{self.path}: contains no {name}; set store: {{signals: all}} and sweep again")
        return time, rows[name][0]
