"""An experiment as it was stored.

Sweeps and defaults are not expanded again, so changes of defaults in later versions have no effect.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.layout import names
from hydrofdi.store.layout.names import axis_variable
from hydrofdi.store.results import MISSING, ShardResults
from hydrofdi.store.signals import FileSignals


@dataclass(frozen=True)
class ExperimentData:
    """An experiment and its results.

    Attributes
    ----------
    path : Path
        The experiment file.
    experiment : ExperimentConfig
        The resolved configuration.
    columns : dict
        Variable name → array with one row per run, without signals.
    versions : dict
        Library → version that computed the results.
    signals : FileSignals | ShardResults
        Location of the signals.
    configuration : dict or None
        The configuration as written in the file, in SI; None if there is no file.
    physics_version : int
        Version of the physics that the runs were computed with.
    remarks : tuple of str
        Remarks that apply to all rows.
    """

    path: Path
    experiment: ExperimentConfig
    columns: dict[str, NDArray[Any]]
    versions: dict[str, str]
    signals: FileSignals | ShardResults
    configuration: dict[str, Any] | None = None
    remarks: tuple[str, ...] = ()
    physics_version: int = PHYSICS_VERSION

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self.columns[names.RUN_ID])

    @property
    def is_whole(self) -> bool:
        """Whether every run has been computed or has failed."""
        return MISSING not in self.columns[names.STATUS]

    @property
    def swept_names(self) -> list[str]:
        """Dotted parameters that the experiment varies."""
        return self.experiment.varied_names

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

    @cached_property
    def replicate_of(self) -> NDArray[np.int64]:
        """Row of the healthy run that each run replicates; `NO_BASELINE` if it is not a replicate."""
        return self.columns.get(names.REPLICATE_OF, np.full(self.n_run, names.NO_BASELINE))

    @property
    def has_replicates(self) -> bool:
        """Whether any run is a replicate."""
        return bool((self.replicate_of != names.NO_BASELINE).any())

    def _sealed(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Baseline rows, without those of leaking runs."""
        return np.where((rows >= 0) & (self.leakage_requests[rows] == 0.0), rows, names.NO_BASELINE)

    def values(self, name: str) -> list[Any]:
        """Value of a dotted parameter in SI, for each run; None if it is not set."""
        variable = axis_variable(name)
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
        """Sampling instants [s] and a signal of one run, each of shape (n_time,).

        Raises
        ------
        StoreError
            The experiment did not store this signal.
        """
        return self.signals.read(name, position)
