"""Experiments read back, finished or not."""

from __future__ import annotations

from pathlib import Path

from hydrofdi.config import expand_runs
from hydrofdi.errors import ReportError
from hydrofdi.pipeline.places import experiment_file, library_versions, newest_directory
from hydrofdi.simulation import run_identity
from hydrofdi.store import (
    ExperimentData,
    ShardResults,
    read_experiment,
    read_failures,
    read_index,
    read_unfinished,
)
from hydrofdi.store.reading import is_current
from hydrofdi.store.request import REQUEST_FILE, read_request


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
        Its file is damaged or of another version.
    """
    if place is not None and not place.is_dir():
        return read_experiment(place)
    directory = newest_directory() if place is None else place
    if (directory / REQUEST_FILE).exists():
        return _read_requested(directory)
    files = list(directory.glob("[!.]*.h5"))
    if not files:
        raise ReportError(f"no experiment file in {directory}; run 'hydrofdi sweep CONFIG' first")
    return read_experiment(max(files, key=lambda file: file.stat().st_mtime_ns))


def _read_requested(directory: Path) -> ExperimentData:
    """What a sweep on the folder has stored, from its file where that is up to date, else from the shards."""
    experiment = read_request(directory)
    file = experiment_file(directory, experiment)
    if is_current(file, experiment):
        return read_experiment(file)
    index = read_index(directory)
    if file.exists() and not index.runs:
        return read_experiment(file)
    table = expand_runs(experiment)
    run_ids = [run_identity(run) for run in table.runs]
    results = ShardResults(run_ids, index.runs, read_failures(directory))
    return read_unfinished(file, experiment, table, results, library_versions())
