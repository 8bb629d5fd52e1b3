"""Variables of a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.store.layout.names import OVER_PHASES, Variable
from hydrofdi.store.layout.outputs import is_output


def is_optional(variable: Variable) -> bool:
    """Whether only some shards contain a variable: signals, features over phases, outputs of indicators."""
    return variable.is_signal or variable in OVER_PHASES or is_output(variable.name)


def held_values(file: h5py.File, variable: Variable, rows: slice) -> NDArray[Any]:
    """Rows of a variable.

    Raises
    ------
    KeyError
        The file lacks it.
    """
    dataset = file[variable.name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{dataset.name} is not a variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[rows] if is_text else dataset[rows])


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
