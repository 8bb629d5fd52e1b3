"""Experiments without an experiment file that is up to date: as far as their shards go."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunTable
from hydrofdi.errors import StoreError
from hydrofdi.store.experiment_file import requested_columns
from hydrofdi.store.names import stored_variables
from hydrofdi.store.reading import ExperimentData
from hydrofdi.store.results import ShardResults
from hydrofdi.store.variables import fill_empty_features


@dataclass(frozen=True)
class ShardSignals:
    """Signals that lie in shards."""

    results: ShardResults

    def read(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run."""
        time = self.results.time()
        try:
            values = self.results.signal(name, slice(position, position + 1))[0]
        except KeyError:
            values = np.empty(0)
        if time is None or values.size == 0:
            raise StoreError(f"the shards hold no {name}; set store: {{signals: all}} and sweep again")
        return time, values


def read_unfinished(
    path: Path,
    experiment: ExperimentConfig,
    table: RunTable,
    results: ShardResults,
    versions: Mapping[str, str],
) -> ExperimentData:
    """An experiment as far as its shards go; runs without a result say why.

    Parameters
    ----------
    path : Path
        Where its file will lie.
    experiment : ExperimentConfig
    table : RunTable
        Its runs.
    results : ShardResults
        What is stored of them.
    versions : mapping
        Library versions.
    """
    kept = stored_variables("none", phases=experiment.measures_phases)
    computed = {variable.name: results.column(variable) for variable in kept}
    fill_empty_features(computed, results.n_run, experiment.wavelet.levels)
    columns = computed | requested_columns(table)
    return ExperimentData(path, experiment, columns, dict(versions), ShardSignals(results))
