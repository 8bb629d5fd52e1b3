"""Arrays with named dimensions and units: xarray."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.report.table import library
from hydrofdi.store.layout import names
from hydrofdi.store.layout.names import Variable
from hydrofdi.store.layout.outputs import output_variables

if TYPE_CHECKING:
    import xarray

    from hydrofdi.store import ExperimentData


def run_variables(experiment: ExperimentConfig) -> tuple[Variable, ...]:
    """Variables of a single run, by their names in experiment files."""
    phases = experiment.wavelet.phase == "all"
    measured = experiment.indicator_choice.made(experiment.wavelet)
    stored = names.stored_variables("all", phases=phases)
    return (*stored, *output_variables([measured]), *names.BY_LEVEL)


def run_dataset(
    variables: Iterable[Variable], columns: Mapping[str, NDArray[Any]], attributes: Mapping[str, str]
) -> xarray.Dataset:
    """One run as a dataset: signals over time, numbers of levels, and single numbers.

    Raises
    ------
    ReportError
        xarray is not installed.
    """
    loaded = library("xarray")
    held = {each.name: each for each in variables if each.name in columns and not each.is_text}
    content = {
        name: (each.dimensions[1:], columns[name][0], {"units": each.units, "long_name": each.long_name})
        for name, each in held.items()
    }
    dataset: xarray.Dataset = loaded.Dataset(content, attrs=dict(attributes))
    time = (names.TIME, columns[names.TIME], {"units": "s", "long_name": "time"})
    coordinates: dict[str, Any] = {names.TIME: time}
    if names.LEVEL in dataset.sizes:
        levels = np.arange(1, dataset.sizes[names.LEVEL] + 1)
        coordinates[names.LEVEL] = (names.LEVEL, levels, {"long_name": "level of the wavelet transform"})
    return dataset.assign_coords(coordinates)


def study_coordinates(data: ExperimentData) -> dict[str, tuple[str, NDArray[Any]]]:
    """Name → dimension and values: population and kind of each run of a study, and whether it is for fitting.

    Raises
    ------
    ReportError
        The file does not contain the runs of its study.
    """
    if data.experiment.study is None:
        return {}
    from hydrofdi.studies.reading import stored_roles

    roles = stored_roles(data)
    populations = [roles.populations[place] for place in roles.of_run]
    columns = {
        "population": [each.name for each in populations],
        "population_kind": [str(each.kind) for each in populations],
        "is_fit": [each.is_fit for each in populations],
    }
    return {name: (names.RUN, np.array(values)) for name, values in columns.items()}
