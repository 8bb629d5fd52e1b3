"""Variables of a file, also those that files of an earlier hydrofdi lack."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.store.names import (
    DETAIL_RMS,
    LATER_ADDED,
    LEVEL,
    OVER_PHASES,
    PHASE,
    RUN,
    Variable,
    stored_variables,
)

_OPTIONAL = {variable.name: variable for variable in (*LATER_ADDED, *OVER_PHASES)}


def holds_variable(file: h5py.File, name: str) -> bool:
    """Whether a file holds a variable; False only for those that it may lack."""
    return name in file or name not in _OPTIONAL


def absent_values(file: h5py.File, name: str) -> NDArray[Any]:
    """NaN in the shape that a variable which a file lacks would have in it."""
    n_run, n_level = file[DETAIL_RMS].shape
    return _nothing(_OPTIONAL[name], n_run, n_level)


def fill_empty_features(columns: dict[str, NDArray[Any]], n_run: int, n_level: int) -> None:
    """Give features of which no run has any the shape that they would have."""
    for variable in stored_variables("none", phases=True):
        if LEVEL in variable.dimensions and variable.name in columns and columns[variable.name].size == 0:
            columns[variable.name] = _nothing(variable, n_run, n_level)


def _nothing(variable: Variable, n_run: int, n_level: int) -> NDArray[Any]:
    sizes = {RUN: n_run, PHASE: 2**n_level, LEVEL: n_level}
    return np.full([sizes[dimension] for dimension in variable.dimensions], np.nan)
