"""Experiments read back, finished or not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from hydrofdi.config import ExperimentConfig, expand_runs
from hydrofdi.errors import ReportError, StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.pipeline.places import (
    experiment_file,
    library_versions,
    newest_directory,
    require_single,
    results_files,
)
from hydrofdi.settings.counting import counted
from hydrofdi.simulation import run_identities
from hydrofdi.store import (
    ExperimentData,
    ShardIndex,
    ShardResults,
    join_results,
    read_experiment,
    read_failures,
    read_index,
    read_unfinished,
)
from hydrofdi.store.layout.names import RUN_ID
from hydrofdi.store.request import REQUEST_FILE, read_request, request_record


def read_results(place: Path | None = None) -> ExperimentData:
    """An experiment as far as it is stored.

    Parameters
    ----------
    place : Path, optional
        Its folder, or its file; by default the folder below ``results/`` that was swept last.

    Raises
    ------
    ReportError
        There is none.
    StoreError
        Its file is damaged or of another version, or the folder of no sweep contains several files.
    """
    if place is not None and not place.is_dir():
        return read_experiment(place)
    directory = newest_directory() if place is None else place
    if (directory / REQUEST_FILE).exists():
        return _read_requested(directory)
    files = results_files(directory)
    if not files:
        raise ReportError(f"no experiment file in {directory}; run 'hydrofdi sweep CONFIG' first")
    require_single(directory, files)
    return read_experiment(files[0])


def _read_requested(directory: Path) -> ExperimentData:
    """What the latest sweep on a folder has stored: from its file, or else from the shards."""
    experiment = read_request(directory)
    file = experiment_file(directory, experiment)
    data = _read_same(file, directory)
    if data is not None and data.is_whole and data.physics_version == PHYSICS_VERSION:
        return data
    index = read_index(directory)
    if file.exists() and not index.runs:
        return read_experiment(file)
    physics_version = max(index.physics_versions, default=PHYSICS_VERSION)
    if data is None or data.physics_version < physics_version:
        return _read_shards(experiment, file, index, physics_version)
    if data.is_whole:
        return data
    run_ids = [str(run_id) for run_id in data.columns[RUN_ID]]
    return join_results(data, ShardResults(run_ids, index, read_failures(directory)))


def _read_same(file: Path, directory: Path) -> ExperimentData | None:
    """The experiment file, if it is sound and holds the latest request of the folder."""
    try:
        data = read_experiment(file)
    except StoreError:
        return None
    return data if data.configuration == request_record(directory) else None


def stored_run_ids(directory: Path, experiment: ExperimentConfig) -> tuple[str, ...] | None:
    """The identities of all runs in the experiment file; None if it does not contain the latest request."""
    data = _read_same(experiment_file(directory, experiment), directory)
    return None if data is None else tuple(map(str, data.columns[RUN_ID]))


def _read_shards(
    experiment: ExperimentConfig, file: Path, index: ShardIndex, physics_version: int
) -> ExperimentData:
    """The runs of an experiment as far as their shards go, each found by its identity."""
    table = expand_runs(experiment)
    run_ids = run_identities(table.runs, physics_version)
    results = ShardResults(run_ids, index, read_failures(file.parent))
    data = read_unfinished(file, experiment, table, results, library_versions())
    data = replace(data, physics_version=physics_version)
    if index.runs and index.runs.keys().isdisjoint(run_ids):
        remark = (
            f"None of the {counted(len(index.runs), 'stored run')} is one of this experiment: the request or "
            f"a default has changed since then; 'hydrofdi sweep' computes the current request."
        )
        data = replace(data, remarks=(remark,))
    return data
