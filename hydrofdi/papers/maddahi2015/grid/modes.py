"""The leaky modes of an experiment as arrays over scenarios, leakages, EBM and levels.

A *scenario* is one set of values of everything that varies besides leakage and EBM: an experiment without
such parameters has a single scenario, an ensemble has thousands. Claims and controls are evaluated on all of
them at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

ABSENT = -1
"""Position of a run that the experiment does not ask for."""

Mode = tuple[int, int]
"""Positions of a leakage and of an EBM in a grid."""


@dataclass(frozen=True)
class ModeGrid:
    """δ of all modes.

    Attributes
    ----------
    scenarios : tuple of dict
        Varied parameter → value in SI, for each scenario.
    leakage_flows : tuple of float
        Leakage levels [m³/s], ascending, without the sealed one; at the normal EBM where K_i itself is given.
    bulk_moduli : tuple of float
        β [Pa], ascending.
    normal : int
        Position of the normal β.
    positions : ndarray of int, shape (n_scenario, 1 + n_leakage, n_bulk_modulus)
        Rows of the runs in the experiment, the sealed ones first; ``ABSENT`` if there is none.
    fixed, matched : ndarray, shape (n_scenario, 1 + n_leakage, n_bulk_modulus, n_level)
        δ [%] against the fixed and the matched baseline; NaN if a run is absent, failed or missing.
    lack : str
        Why there are no modes to compare, as a sentence: it then holds a single run.
    """

    scenarios: tuple[dict[str, Any], ...]
    leakage_flows: tuple[float, ...]
    bulk_moduli: tuple[float, ...]
    normal: int
    positions: NDArray[np.int64]
    fixed: NDArray[np.float64]
    matched: NDArray[np.float64]
    lack: str = ""

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return int(self.fixed.shape[-1])

    @property
    def leaky(self) -> NDArray[np.float64]:
        """δ against the fixed baseline of the leaky modes."""
        return self.fixed[:, 1:]

    def planned(self, leakage: int, bulk_modulus: int) -> bool:
        """Whether the experiment asks for a leaky mode."""
        return bool(self.positions[:, 1 + leakage, bulk_modulus].min() > ABSENT)

    def modes(self, leakage: int | None = None, bulk_modulus: int | None = None) -> list[Mode]:
        """The leaky modes that the experiment asks for; all, or those of one leakage or EBM."""
        leakages = range(len(self.leakage_flows)) if leakage is None else (leakage,)
        moduli = range(len(self.bulk_moduli)) if bulk_modulus is None else (bulk_modulus,)
        return [(q, b) for q in leakages for b in moduli if self.planned(q, b)]

    @cached_property
    def n_mode(self) -> int:
        """How many leaky modes the experiment asks for."""
        return len(self.modes())

    @property
    def raised(self) -> list[int]:
        """Positions of the β above the normal one."""
        return list(range(self.normal + 1, len(self.bulk_moduli)))


def gathered(changes: NDArray[np.float64], positions: NDArray[np.int64]) -> NDArray[np.float64]:
    """δ of runs, shape (n_run, n_level), at the places of a grid; NaN if a run is absent."""
    return np.where((positions == ABSENT)[..., None], np.nan, changes[positions])
