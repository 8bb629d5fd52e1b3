"""From an experiment to its results: the verbs of sweeps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from numbers import Real
from os import PathLike
from typing import TYPE_CHECKING, Literal, Unpack

from hydrofdi.api.results import Results
from hydrofdi.config.loading import Experiment, load_experiment
from hydrofdi.config.values import shown_in
from hydrofdi.errors import ConfigError, SweepInterrupted
from hydrofdi.execution.plan import WHOLE, Plan, part_of, planned
from hydrofdi.settings.arguments import count_of, path_of, positive_of
from hydrofdi.store.results import experiment_directory, read_results
from hydrofdi.tables.table import Table

if TYPE_CHECKING:
    from hydrofdi.api.settings import Settings
    from hydrofdi.execution.checking import Check


def check(experiment: Experiment | None = None, /, **settings: Unpack[Settings]) -> Check:
    """Look at an experiment before running it, as ``hydrofdi check`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        By default the nominal actuator.
    **settings
        As in `hydrofdi.simulate`.

    Raises
    ------
    ConfigError
        With every mistake, or a leakage flow that cannot be reached.

    Examples
    --------
    >>> import hydrofdi
    >>> found = hydrofdi.check(duration="2 s", step="1 ms")
    >>> bool(found)
    False
    >>> found.problems[0]
    'the step of 0.001 s is too long for the friction zone: ...'
    """
    from hydrofdi.execution.checking import checked

    return checked(load_experiment(experiment, settings))


def calibrate(
    experiment: Experiment | None = None,
    /,
    *,
    flows: str | float | Sequence[str | float] = (),
    **settings: Unpack[Settings],
) -> Table:
    """The leakage coefficients of mean leakage flows, under the conditions of the baseline.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        By default the nominal actuator.
    flows : str, float, or sequence of them
        Mean leakage flows such as ``0.12 L/min``, or numbers in SI [m³/s].
    **settings
        As in `hydrofdi.simulate`.

    Returns
    -------
    Table
        A row for each flow: ``flow``, mean of abs(q_il) [m³/s]; ``coefficient``, K_i of the orifice law
        [m^3.5/kg^0.5].

    Raises
    ------
    ConfigError
        With every mistake, or a flow that cannot be reached.

    Examples
    --------
    >>> import hydrofdi
    >>> (target,) = hydrofdi.calibrate(flows=["0.12 L/min"], duration="2 s")
    >>> f"{target['coefficient']:.1e} m³/s/√Pa"
    '...e-10 m³/s/√Pa'
    """
    if isinstance(flows, str | Real) or not isinstance(flows, Iterable):
        flows = [flows]
    what = "a flow such as '0.12 L/min', or a number in m³/s"
    values = [positive_of("flows", flow, "m^3/s", what) for flow in flows]
    if not values:
        raise ConfigError("flows: name at least one, e.g. 0.12 L/min")
    from hydrofdi.execution.checking import calibrated

    return calibrated(load_experiment(experiment, settings), values)


def plan(
    experiment: Experiment | None = None,
    /,
    *,
    out: str | PathLike[str] | None = None,
    workers: int | None = None,
    retry_failed: bool = False,
    **settings: Unpack[Settings],
) -> Plan:
    """What `hydrofdi.sweep` would do, as ``hydrofdi plan`` says it. Writes nothing.

    Parameters
    ----------
    experiment, out, workers, retry_failed, **settings
        As in `hydrofdi.sweep`.

    Raises
    ------
    ConfigError
        With every mistake.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "planned", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> plan = hydrofdi.plan(study)
    >>> plan
    experiment            planned → results/planned/planned.h5
    runs                  2
    ...
    >>> plan.reasons
    {'new': 2}
    """
    n_worker = None if workers is None else count_of("workers", workers)
    loaded = load_experiment({} if experiment is None else experiment, settings)
    with shown_in(loaded.units):
        directory = experiment_directory(loaded, None if out is None else path_of(out))
        return planned(loaded, directory, n_worker, retry_failed=retry_failed)


def sweep(
    experiment: Experiment | None = None,
    /,
    *,
    out: str | PathLike[str] | None = None,
    workers: int | None = None,
    engine: Literal["local", "in-process", "dask"] = "local",
    scheduler: str | None = None,
    shared_directory: bool = True,
    part: str | None = None,
    retry_failed: bool = False,
    progress: bool = False,
    **settings: Unpack[Settings],
) -> Results:
    """Run whatever is missing and store it, as ``hydrofdi sweep`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        YAML file, or what would stand in one; without it, the nominal actuator with the settings.
    out : path, optional
        Folder of the results; ``results/<name>`` where it is left out.
    workers : int, optional
        Processes; the cores that hydrofdi may use where it is left out.
    engine : {"local", "in-process", "dask"}
        Where runs are computed: in worker processes, in this process, or on a Dask cluster.
    scheduler : str, optional
        Address of the Dask scheduler, such as tcp://host:8786.
    shared_directory : bool
        Dask workers write into the results folder (the default), or send their results.
    part : str, optional
        Only this part of the runs, such as 3/64; ``hydrofdi collect`` joins the parts of all machines.
    retry_failed : bool
        Retry runs that raised an error, hung or lost their worker.
    progress : bool
        Show warnings and progress on standard error.
    **settings
        As in `hydrofdi.simulate`; also what varies: ``grid={"EBM": ["551 MPa", "689 MPa"]}``.

    Raises
    ------
    ConfigError
        With every mistake; nothing is written then.
    StoreError
        The folder is in use, or cannot be written.
    HydrofdiError
        The Dask cluster has ended; the same call continues from what is stored.
    KeyboardInterrupt
        Ctrl-C: a `SweepInterrupted`, after what ran is stored; the same call continues from there.

    Examples
    --------
    >>> import hydrofdi
    >>> grid = {"EBM": ["551 MPa", "689 MPa"]}
    >>> results = hydrofdi.sweep(name="stiffness", duration="2 s", grid=grid, engine="in-process")
    >>> results
    2 runs in results/stiffness: 2 ok; 1 warning, see .warnings
    >>> results.dataset.chamber_1_pressure.sizes["run"]
    2
    >>> results.statuses
    {'ok': 2}
    """
    from hydrofdi.execution.engines import engine_named
    from hydrofdi.execution.sweeping import run_sweep, watching

    with watching(progress) as watcher:
        loaded = load_experiment({} if experiment is None else experiment, settings)
        n_worker = None if workers is None else count_of("workers", workers)
        directory = experiment_directory(loaded, None if out is None else path_of(out))
        own = WHOLE if part is None else part_of(part)
        chosen = engine_named(engine, n_worker, scheduler, shared_directory=shared_directory)
        with shown_in(loaded.units):
            summary = run_sweep(loaded, directory, chosen, watcher, retry_failed=retry_failed, part=own)
    if summary.interrupted:
        raise SweepInterrupted(summary.completed, summary.stored, summary.planned, summary)
    return Results(read_results(directory) if own == WHOLE else directory, summary)


def collect(folder: str | PathLike[str] | Results) -> Results:
    """Build the experiment file from what is stored; runs without a result are holes with a reason.

    Raises
    ------
    StoreError
        The folder contains no experiment, a sweep is at work there, or the file cannot be written.

    Examples
    --------
    >>> import hydrofdi
    >>> study = {"name": "asked", "record": {"duration": "2 s"}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.collect(results.folder)
    1 run in results/asked: 1 ok
    """
    from hydrofdi.execution.sweeping import collected

    directory = path_of(folder)
    collected(directory)
    return Results(read_results(directory))
