"""Sweeps: plan what is missing, run it, and store it."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import Any, Literal

from hydrofdi.api.arguments import choice_of, count_of
from hydrofdi.api.experiments import Experiment, stated_experiment
from hydrofdi.api.places import path_of
from hydrofdi.api.progress import Progress, watching
from hydrofdi.api.results import Results
from hydrofdi.config.shown_values import shown_in
from hydrofdi.errors import SweepInterrupted
from hydrofdi.pipeline.engines import ENGINES, make_engine
from hydrofdi.pipeline.places import experiment_directory
from hydrofdi.pipeline.results import read_results
from hydrofdi.pipeline.sweeping import run_sweep


def sweep(
    experiment: Experiment,
    /,
    *,
    out: str | PathLike[str] | None = None,
    workers: int | None = None,
    engine: Literal["local", "in-process", "dask"] = "local",
    scheduler: str | None = None,
    shared_directory: bool = True,
    retry_failed: bool = False,
    progress: bool | Callable[[Progress], object] = False,
    **settings: Any,
) -> Results:
    """Run whatever is missing and store it, as ``hydrofdi sweep`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig
        YAML file, or what would stand in one.
    out : path, optional
        Folder of the results; ``results/<name>`` where it is left out.
    workers : int, optional
        Processes; the cores that hydrofdi may use where it is left out.
    engine : {"local", "in-process", "dask"}
        In processes of their own, in this one, or on a Dask cluster.
    scheduler : str, optional
        Address of the Dask scheduler, such as ``tcp://host:8786``.
    shared_directory : bool
        Whether Dask workers reach the folder of the results.
    retry_failed : bool
        Whether runs that raised, hung or lost their worker are tried again.
    progress : bool or callable
        True shows warnings and progress on standard error; a function is called with each `Progress`.
    **settings
        As in `hydrofdi.simulate`.

    Raises
    ------
    ConfigError
        With every mistake; nothing is written then.
    StoreError
        The folder is in use, or cannot be written.
    KeyboardInterrupt
        Ctrl-C: a `SweepInterrupted`, after what ran is stored; the same call continues from there.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "stiffness", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> results
    2 runs in results/stiffness: 2 ok; ... warnings, see .warnings
    >>> results.dataset.chamber_1_pressure.sizes["run"]
    2
    >>> results.statuses
    {'ok': 2}
    """
    with watching(progress) as watcher:
        loaded = stated_experiment(experiment, settings)
        n_worker = None if workers is None else count_of("workers", workers)
        directory = experiment_directory(loaded, None if out is None else path_of(out))
        chosen = make_engine(
            choice_of("engine", engine, ENGINES), n_worker, scheduler, shared_directory=shared_directory
        )
        with shown_in(loaded.units):
            summary = run_sweep(loaded, directory, chosen, watcher, retry_failed=retry_failed)
    if summary.interrupted:
        raise SweepInterrupted(summary.completed, summary.stored, summary.planned, summary)
    return Results(read_results(directory), summary)
