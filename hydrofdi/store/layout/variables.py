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
    """Rows of a variable; None if a file lacks what it may lack.

    Raises
    ------
    KeyError
        The file lacks what each has.
    """
    name = variable.name
    if name not in file and is_output(name):
        return earlier_output(file, name, rows)
    if name not in file and name in _OPTIONAL:
        return None
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{dataset.name} is no variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[rows] if is_text else dataset[rows])


def absent_values(file: h5py.File, variable: Variable) -> NDArray[Any]:
    """NaN, or no text, in the shape that a variable which a file lacks would have in it."""
    n_level = next((file[name].shape[-1] for name in (DETAIL_RMS, SETTLED_DETAIL_RMS) if name in file), 0)
    sizes = {RUN: len(file[RUN_ID]), LEVEL: n_level, PHASE: 2**n_level}
    blank, kind = ("", object) if variable.is_text else (np.nan, float)
    return np.full([sizes[dimension] for dimension in variable.dimensions], blank, kind)


def fit_to_dimensions(
    columns: dict[str, NDArray[Any]], variables: Sequence[Variable], sizes: Mapping[str, int]
) -> None:
    """Give numbers the shape of their dimensions, where no run or none of the largest has a result.

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
    """Values in a shape that is no smaller; NaN beyond."""
    if values.shape == shape:
        return values
    whole = np.full(shape, np.nan)
    whole[tuple(slice(size) for size in values.shape)] = values
    return whole
