"""Variables of a file, including those missing in files of an earlier hydrofdi."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.store.layout.names import (
    DETAIL_RMS,
    LATER_ADDED,
    LEVEL,
    OVER_PHASES,
    PHASE,
    RUN,
    RUN_ID,
    SETTLED_DETAIL_RMS,
    Variable,
)
from hydrofdi.store.layout.outputs import is_output
from hydrofdi.store.layout.wavelet_numbers import earlier_output

_OPTIONAL = {variable.name for variable in (*LATER_ADDED, *OVER_PHASES)}


def held_values(file: h5py.File, variable: Variable, rows: slice) -> NDArray[Any] | None:
    """Rows of a variable; None if the file lacks an optional variable.

    Raises
    ------
    KeyError
        The file lacks a required variable.
    """
    name = variable.name
    if name not in file and is_output(name):
        return earlier_output(file, name, rows)
    if name not in file and name in _OPTIONAL:
        return None
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{dataset.name} is not a variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[rows] if is_text else dataset[rows])


def absent_values(file: h5py.File, variable: Variable) -> NDArray[Any]:
    """NaN or empty text, in the shape that the missing variable would have in the file."""
    n_level = next((file[name].shape[-1] for name in (DETAIL_RMS, SETTLED_DETAIL_RMS) if name in file), 0)
    sizes = {RUN: len(file[RUN_ID]), LEVEL: n_level, PHASE: 2**n_level}
    blank, kind = ("", object) if variable.is_text else (np.nan, float)
    return np.full([sizes[dimension] for dimension in variable.dimensions], blank, kind)


def fit_to_dimensions(
    columns: dict[str, NDArray[Any]], variables: Sequence[Variable], sizes: Mapping[str, int]
) -> None:
    """Enlarge variables to the given dimensions, if no run with a result has the full length.

    Parameters
    ----------
    columns : dict
    variables : sequence of Variable
    sizes : mapping
        Length of each dimension.
    """
    for variable in variables:
        shape = tuple(sizes[dimension] for dimension in variable.dimensions)
        columns[variable.name] = enlarged(columns[variable.name], shape)


def enlarged(values: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Values padded with NaN to a larger shape."""
    if values.shape == shape:
        return values
    whole = np.full(shape, np.nan)
    whole[tuple(slice(size) for size in values.shape)] = values
    return whole
