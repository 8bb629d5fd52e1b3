"""The experiment file: all runs of an experiment as one labelled data set.

It opens with h5py, and with xarray (engine ``h5netcdf``) as a data set with the dimensions run, time, level.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunTable
from hydrofdi.config.parameters import parameter_unit
from hydrofdi.store.files import whole_file
from hydrofdi.store.names import (
    BULK_MODULUS,
    COMPUTED,
    DETAIL_RMS,
    FIXED_BASELINE,
    FORMAT_VERSION,
    INPUT_VOLTAGE,
    LEAKAGE_LEVEL,
    LEVEL,
    MATCHED_BASELINE,
    REQUESTED,
    RUN,
    TIME,
    Variable,
    axis_variable,
    stored_variables,
)
from hydrofdi.store.shard import Columns, ShardRow, read_rows


class ShardColumns(Mapping[str, NDArray[Any]]):
    """Columns that are read from shards when they are asked for.

    Parameters
    ----------
    rows : sequence of ShardRow
        One per run, in the order wanted.
    signals : str
        Which signals to read, as in ``store.signals``.
    """

    def __init__(self, rows: Sequence[ShardRow], signals: str) -> None:
        self._rows = rows
        self._names = [variable.name for variable in stored_variables(signals)]
        if signals != "none":
            self._names.append(TIME)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._names:
            raise KeyError(name)
        if name == TIME:
            with h5py.File(self._rows[0].path) as file:
                return np.asarray(file[TIME][:])
        column: NDArray[Any] | None = None
        for positions, values in read_rows(self._rows, name):
            if column is None:
                column = _empty_column(values, len(self._rows))
            if column.ndim == 2 and values.shape[1] > column.shape[1]:
                column = _widened(column, values.shape[1])
            target = column if column.ndim == 1 else column[:, : values.shape[1]]
            target[positions] = values
        assert column is not None
        return column

    def __iter__(self) -> Any:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _empty_column(values: NDArray[Any], n_run: int) -> NDArray[Any]:
    shape = (n_run, *values.shape[1:])
    return np.full(shape, np.nan) if values.dtype.kind == "f" else np.empty(shape, values.dtype)


def _widened(column: NDArray[Any], width: int) -> NDArray[Any]:
    wider = np.full((column.shape[0], width), np.nan)
    wider[:, : column.shape[1]] = column
    return wider


def write_experiment(
    path: Path, experiment: ExperimentConfig, table: RunTable, columns: Columns, versions: Mapping[str, str]
) -> None:
    """Write the experiment file, whole or not at all.

    Parameters
    ----------
    path : Path
    experiment : ExperimentConfig
        Stored as the attribute ``configuration``.
    table : RunTable
        The runs in the order of the rows.
    columns : mapping
        Computed variables, one row per run.
    versions : mapping
        Library versions, stored as attributes ``version_<name>``.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    with whole_file(path) as aside, h5py.File(aside, "w") as file:
        file.attrs["title"] = f"hydrofdi experiment {experiment.name}"
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["configuration"] = experiment.model_dump_json()
        for name, version in sorted(versions.items()):
            file.attrs[f"version_{name}"] = version
        requested = _requested_columns(table)
        shared_input = len({(run.parameters.input, run.parameters.run) for run in table.runs}) == 1
        _write_coordinates(file, columns, len(table.runs))
        for variable in (*REQUESTED, *_axis_variables(table), *COMPUTED):
            if variable.name in requested:
                _write_variable(file, variable, requested[variable.name])
            elif variable.name in columns:
                is_shared = variable.name == INPUT_VOLTAGE and shared_input
                values = columns[variable.name]
                _write_variable(file, variable, values[0] if is_shared else values, shared=is_shared)


def _write_coordinates(file: h5py.File, columns: Columns, n_run: int) -> None:
    coordinates = [
        (RUN, np.arange(n_run), "", "position of the run in the experiment"),
        (LEVEL, np.arange(1, columns[DETAIL_RMS].shape[1] + 1), "", "level of the wavelet transform"),
    ]
    if TIME in columns:
        coordinates.append((TIME, columns[TIME], "s", "time"))
    for name, values, units, long_name in coordinates:
        dataset = file.create_dataset(name, data=values)
        dataset.make_scale(name)
        _describe(dataset, units, long_name)


def _write_variable(
    file: h5py.File, variable: Variable, values: NDArray[Any], *, shared: bool = False
) -> None:
    if variable.is_text or values.dtype.kind in "OU":
        dataset = file.create_dataset(
            variable.name, data=[str(text) for text in values], dtype=h5py.string_dtype()
        )
    else:
        dataset = file.create_dataset(variable.name, data=values)
    for axis, dimension in enumerate(variable.dimensions[1:] if shared else variable.dimensions):
        dataset.dims[axis].attach_scale(file[dimension])
    _describe(dataset, variable.units, variable.long_name)


def _describe(dataset: h5py.Dataset, units: str, long_name: str) -> None:
    dataset.attrs["units"] = units
    dataset.attrs["long_name"] = long_name


def _requested_columns(table: RunTable) -> dict[str, NDArray[Any]]:
    leakages = [run.parameters.leakage for run in table.runs]
    levels = [
        leakage.internal_flow
        if leakage.needs_calibration
        else np.nan
        if leakage.internal_coefficient
        else 0.0
        for leakage in leakages
    ]
    columns = {
        BULK_MODULUS: np.array([run.parameters.fluid.bulk_modulus for run in table.runs]),
        LEAKAGE_LEVEL: np.array(levels, dtype=float),
        FIXED_BASELINE: np.array(table.fixed_baseline),
        MATCHED_BASELINE: np.array(table.matched_baseline),
    }
    for variable, parameter in zip(_axis_variables(table), _plain_axes(table), strict=True):
        columns[variable.name] = np.array([run.parameters.value(parameter) for run in table.runs])
    return columns


def _plain_axes(table: RunTable) -> list[str]:
    """Swept parameters that no other variable of the file holds."""
    return [
        name
        for name in table.axes
        if name != "fluid.bulk_modulus" and not name.startswith("leakage.internal")
    ]


def _axis_variables(table: RunTable) -> list[Variable]:
    return [
        Variable(axis_variable(name), (RUN,), parameter_unit(name) or "", f"swept parameter {name}")
        for name in _plain_axes(table)
    ]
