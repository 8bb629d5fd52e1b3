"""Reading of experiments without an up-to-date experiment file, from their shards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunTable
from hydrofdi.errors import StoreError
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.experiment_file import computed_columns, requested_columns
from hydrofdi.store.layout.names import LEAKAGE_COEFFICIENT, RUN, Variable, stored_variables
from hydrofdi.store.layout.outputs import is_output
from hydrofdi.store.layout.variables import enlarged
from hydrofdi.store.layout.wavelet_numbers import wavelet_numbers
from hydrofdi.store.results import ShardResults


@dataclass(frozen=True)
class ShardSignals:
    """Signals in shards."""

    results: ShardResults

    def read(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run, each of shape (n_time,)."""
        time = self.results.time()
        values = self.results.signal(name, position)
        if time is None or values.size == 0:
            raise StoreError(f"the shards contain no {name}; set store: {{signals: all}} and sweep again")
        return time, values

    def rows(self, names: Sequence[str], positions: Sequence[int]) -> dict[str, NDArray[np.float64]]:
        """Signals of some runs by name; signals in no shard are omitted."""
        return self.results.signal_rows(names, positions)


def read_unfinished(
    path: Path,
    experiment: ExperimentConfig,
    table: RunTable,
    results: ShardResults,
    versions: Mapping[str, str],
) -> ExperimentData:
    """Read an experiment from its shards; runs without a result contain the reason.

    Parameters
    ----------
    path : Path
        Future path of the experiment file.
    experiment : ExperimentConfig
    table : RunTable
        Runs of the experiment.
    results : ShardResults
        Stored results of the runs.
    versions : mapping
        Library versions.
    """
    columns = computed_columns(results, table) | requested_columns(table)
    columns |= wavelet_numbers(columns)
    return ExperimentData(path, experiment, columns, dict(versions), ShardSignals(results))


def join_results(data: ExperimentData, results: ShardResults) -> ExperimentData:
    """Add the runs that shards contain so far to the data of an experiment file.

    Parameters
    ----------
    data : ExperimentData
    results : ShardResults
        Results of the runs of the file, in the same order.
    """
    held = [variable for variable in stored_variables("none", phases=True) if variable.name in data.columns]
    outputs = [name for name in data.columns if is_output(name)]
    variables = [
        *held,
        *(Variable(name, (RUN, *[name] * (data.columns[name].ndim - 1)), "", "") for name in outputs),
    ]
    computed = results.columns(variables)
    given = data.columns[LEAKAGE_COEFFICIENT]
    solved = computed[LEAKAGE_COEFFICIENT]
    computed[LEAKAGE_COEFFICIENT] = np.where(np.isnan(solved), given, solved)
    columns = data.columns | {name: enlarged(computed[name], data.columns[name].shape) for name in computed}
    return replace(data, columns=columns | wavelet_numbers(columns), signals=ShardSignals(results))
