"""Variables of a file, also those that files of an earlier hydrofdi lack."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.store.names import DETAIL_RMS, LATER_ADDED

_ADDED = {variable.name: variable for variable in LATER_ADDED}


def holds_variable(file: h5py.File, name: str) -> bool:
    """Whether a file holds a variable; False only for those that were added after it was written."""
    return name in file or name not in _ADDED


def absent_values(file: h5py.File, name: str) -> NDArray[Any]:
    """NaN in the shape that an added variable would have in a file."""
    shape = file[DETAIL_RMS].shape
    return np.full(shape[: len(_ADDED[name].dimensions)], np.nan)
