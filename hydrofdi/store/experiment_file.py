"""The experiment file: all runs as one labelled data set, which xarray opens with the engine ``h5netcdf``.

Its bytes depend only on the configuration, the results and the library versions.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunTable
from hydrofdi.config.drive import without_contents
from hydrofdi.config.experiment import stored_attributes
from hydrofdi.config.loading import stored_experiment
from hydrofdi.config.request import parameter_unit
from hydrofdi.config.runs import PHYSICS_VERSION
from hydrofdi.errors import StoreError
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.files import LIBRARY_VERSIONS, open_for_reading, whole_file
from hydrofdi.store.names import Variable
from hydrofdi.store.shards import (
    FileSignals,
    ShardResults,
    create_column,
    create_signal,
    values_in,
    write_rows,
)

if TYPE_CHECKING:
    import h5py

_BLOCK_BYTES = 10_000_000
"""Approximate size of the rows of a signal that are in memory while they are copied [bytes]."""

_VERSION = "version_"
"""Prefix of the attributes that contain library versions."""


def write_experiment(
    path: Path,
    experiment: ExperimentConfig,
    table: RunTable,
    results: ShardResults,
    versions: Mapping[str, str],
) -> None:
    """Write the experiment file atomically."""
    import h5py

    time = results.time() if experiment.store.signals != "none" else None
    kept = names.stored_signals(experiment.store.signals) - experiment.absent_signals
    signals = [variable for variable in names.COMPUTED if variable.name in kept]
    with whole_file(path) as aside, h5py.File(aside, "w", libver=LIBRARY_VERSIONS) as file:
        file.attrs["title"] = f"hydrofdi experiment {experiment.name}"
        file.attrs["format_version"] = names.FORMAT_VERSION
        file.attrs["physics_version"] = PHYSICS_VERSION
        file.attrs["configuration"] = experiment.model_dump_json()
        for library, version in sorted(versions.items()):
            file.attrs[f"{_VERSION}{library}"] = version
        _write_coordinates(file, time, names.dimensions(table.runs))
        for variable, values in columns_of(results, table).items():
            _write_column(file, variable, values)
        if axes := coordinates_of(table):
            file.attrs["coordinates"] = " ".join(variable.name for variable in axes)
            for variable, values in axes.items():
                _write_column(file, variable, values)
            file[names.SWEPT.name].attrs["dtype"] = "bool"  # as xarray marks it
        # a wavelet that varies is stored as a swept parameter
        for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items():
            file[f"{label}{names.ANALYSIS_ID}"].attrs.update(stored_attributes(indicator))
        for variable in signals if time is not None else ():
            if variable.name == names.INPUT_VOLTAGE and _share_input(table):
                _write_shared_input(file, variable, results, experiment)
            else:
                _write_signal(file, variable, results, experiment)


def computed_variables(table: RunTable) -> tuple[Variable, ...]:
    """Variables that the runs of a table compute, without signals."""
    wavelets = [request.wavelet for request in table.runs.distinct("wavelet")]
    computed = names.stored_variables("none", phases=any(wavelet.phase == "all" for wavelet in wavelets))
    return (*computed, *names.output_variables(map(table.runs.choice.made, wavelets)))


def columns_of(results: ShardResults, table: RunTable) -> dict[Variable, NDArray[Any]]:
    """All variables of the runs of a table but signals; gaps for runs without results."""
    variables = computed_variables(table)
    computed = results.columns(variables, names.dimensions(table.runs))
    given = np.array(table.runs.values("leakage.internal_coefficient"), dtype=float)
    solved = computed[names.LEAKAGE_COEFFICIENT]
    computed[names.LEAKAGE_COEFFICIENT] = np.where(np.isnan(solved), given, solved)
    computed |= names.wavelet_numbers(computed)
    columns = requested_columns(table)
    columns |= {each: computed[each.name] for each in (*variables, *names.BY_LEVEL) if each.name in computed}
    return {each: values for each, values in columns.items() if not names.is_needless(each.name, values)}


def _share_input(table: RunTable) -> bool:
    """Whether all runs have the same input voltage."""
    runs = list(table.runs.distinct("input", "record", "control", "measurement", "voltage_sensor"))
    are_shown = all(run.is_shown_exactly("voltage_sensor") and not run.control.is_closed for run in runs)
    return are_shown and len({(run.input, run.record) for run in runs}) == 1


_LONG_NAMES = {
    names.RUN: "position of the run in the experiment",
    names.LEVEL: "level of the wavelet transform",
    names.PHASE: "sample that the analysed record starts at",
    names.TIME: "time",
}


def _write_coordinates(file: h5py.File, time: NDArray[np.float64] | None, sizes: Mapping[str, int]) -> None:
    coordinates: dict[str, NDArray[Any]] = {
        name: np.arange(length) + (name == names.LEVEL)
        for name, length in sizes.items()
        if length or name != names.PHASE
    }
    if time is not None:
        coordinates[names.TIME] = time
    for name, values in coordinates.items():
        dataset = file.create_dataset(name, data=values)
        dataset.make_scale(name)
        label, _, dimension = name.partition(".")
        long_name = _LONG_NAMES.get(name, f"{dimension} of {label}")
        _describe(dataset, "s" if name == names.TIME else "", long_name)


def _write_column(file: h5py.File, variable: Variable, values: NDArray[Any]) -> None:
    _label(file, create_column(file, variable.name, values), variable, variable.dimensions)


def _write_shared_input(
    file: h5py.File, variable: Variable, results: ShardResults, experiment: ExperimentConfig
) -> None:
    signals = (results.signal(variable.name, position) for position in range(results.n_run))
    voltage = next((values for values in signals if values.size), None)
    if voltage is not None:
        dataset = file.create_dataset(variable.name, data=voltage.astype(experiment.store.dtype))
        _label(file, dataset, variable, variable.dimensions[1:])


def _write_signal(
    file: h5py.File, variable: Variable, results: ShardResults, experiment: ExperimentConfig
) -> None:
    shape = (results.n_run, file[names.TIME].shape[0])
    still = None
    if variable.is_mostly_still:
        still = next(iter(results.signal(variable.name, 0)), np.nan)
    dataset = create_signal(file, variable.name, shape, experiment.store, still)
    at_once = max(1, _BLOCK_BYTES // (8 * shape[1]))
    for first in range(0, shape[0], at_once):
        positions = range(shape[0])[first : first + at_once]
        rows = results.rows([variable.name], positions).get(variable.name)
        write_rows(dataset, first, np.full((len(positions), shape[1]), np.nan) if rows is None else rows)
    _label(file, dataset, variable, variable.dimensions)


def _label(file: h5py.File, dataset: h5py.Dataset, variable: Variable, dimensions: tuple[str, ...]) -> None:
    for axis, dimension in enumerate(dimensions):
        dataset.dims[axis].attach_scale(file[dimension])
    _describe(dataset, variable.units, variable.long_name)


def _describe(dataset: h5py.Dataset, units: str, long_name: str) -> None:
    dataset.attrs["units"] = units
    dataset.attrs["long_name"] = long_name


def requested_columns(table: RunTable) -> dict[Variable, NDArray[Any]]:
    """Variables of each run that come from the experiment, in addition to the computed ones."""
    flows, coefficients = (
        table.runs.values(name) for name in ("leakage.internal_flow", "leakage.internal_coefficient")
    )
    levels = [
        flow or (np.nan if coefficient else 0.0)
        for flow, coefficient in zip(flows, coefficients, strict=True)
    ]
    rows = (table.fixed_baseline, table.matched_baseline)
    values = (np.array(table.runs.values("fluid.bulk_modulus")), np.array(levels, dtype=float), *rows)
    columns: dict[Variable, NDArray[Any]] = dict(zip(names.REQUESTED, values, strict=True))
    for name in table.axes:
        if name != "fluid.bulk_modulus" and not name.startswith("leakage.internal"):
            own = _axis_values(table, name)
            unit = "" if own.dtype == object else parameter_unit(name) or ""
            columns[Variable(names.axis_variable(name), (names.RUN,), unit, f"swept parameter {name}")] = own
    return columns


def coordinates_of(table: RunTable) -> dict[Variable, NDArray[Any]]:
    """Swept parameters by short names, to index runs by, and which runs are points of the sweep."""
    if table.study is not None or not table.axes:
        return {}
    is_swept = np.arange(len(table.runs)) < table.n_swept
    coordinates: dict[Variable, NDArray[Any]] = {names.SWEPT: is_swept.astype(np.int8)}
    for name in table.axes:
        values = _axis_values(table, name)
        if name == "leakage.internal_flow":
            sealed = np.array(table.runs.values("leakage.internal_coefficient"), dtype=float) == 0.0
            values = np.where(sealed, 0.0, values)
        unit = "" if values.dtype == object else names.cf_unit(parameter_unit(name) or "")
        coordinates[Variable(names.coordinate(name), (names.RUN,), unit, f"swept parameter {name}")] = values
    return coordinates


def _axis_values(table: RunTable, parameter: str) -> NDArray[Any]:
    """Values of a swept parameter: numbers with NaN for unset values, or text if any value is text."""
    values = [without_contents(value) for value in table.runs.values(parameter)]
    if not any(isinstance(value, str) for value in values):
        return np.array([np.nan if value is None else value for value in values])
    unit = parameter_unit(parameter) or ""
    texts = [f"{value:.15g} {unit}".strip() if isinstance(value, float) else value for value in values]
    return np.array(["" if text is None else str(text) for text in texts], dtype=object)


def read_experiment(path: Path) -> ExperimentData:
    """Read an experiment file; signals stay on disk."""
    with _experiment_file(path) as file:
        writer = file.attrs.get(f"{_VERSION}hydrofdi", "an unknown version")
        experiment = stored_experiment(
            file.attrs["configuration"], f"{path}: its configuration (hydrofdi {writer} wrote it)"
        )
        stored = (*names.REQUESTED, *names.stored_variables("none", phases=names.PHASE in file))
        axes = {names.axis_variable(name) for name in experiment.varied_names}
        others = [name for name in file if name in axes or ("." in name and not file[name].is_scale)]
        columns = {name: values_in(file, name) for name in (*(variable.name for variable in stored), *others)}
        columns |= names.wavelet_numbers(columns)
        if len({len(values) for values in columns.values()}) != 1:
            raise StoreError(f"{path}: is damaged: its variables differ in their number of runs")
        versions = {
            name.removeprefix(_VERSION): str(value)
            for name, value in file.attrs.items()
            if name.startswith(_VERSION)
        }
        absent = {
            label: dict(file[f"{label}{names.ANALYSIS_ID}"].attrs)
            for label in experiment.indicator_choice.absent
        }
        return ExperimentData(
            path,
            experiment,
            columns,
            versions,
            FileSignals(path),
            json.loads(file.attrs["configuration"]),
            physics_version=int(file.attrs["physics_version"]),
            attributes=absent,
        )


def is_current(path: Path, experiment: ExperimentConfig) -> bool:
    """Whether an experiment file contains all runs of this exact configuration."""
    try:
        with _experiment_file(path) as file:
            same = file.attrs["configuration"] == experiment.model_dump_json()
            current = file.attrs["physics_version"] == PHYSICS_VERSION
            return bool(same and current and names.MISSING not in file[names.STATUS].asstr()[:])
    except StoreError:
        return False


def read_texts(path: Path, name: str) -> dict[str, list[str]]:
    """Name → text of each run, of a variable, or of all variables with a suffix such as ``.obstacle``."""
    with _experiment_file(path) as file:
        named = [own for own in file if own == name or (name.startswith(".") and own.endswith(name))]
        return {own: list(file[own].asstr()[:]) for own in named}


@contextmanager
def _experiment_file(path: Path) -> Iterator[h5py.File]:
    with open_for_reading(path) as file:
        version = file.attrs.get("format_version")
        if version is None or "configuration" not in file.attrs:
            raise StoreError(f"{path}: is not an experiment file of hydrofdi")
        if version != names.FORMAT_VERSION:
            can = "no longer reads" if version < names.FORMAT_VERSION else "does not read yet"
            raise StoreError(
                f"{path}: has format version {version}, which this hydrofdi {can}"
                f" (it reads {names.FORMAT_VERSION}); sweep again into another folder"
            )
        yield file
