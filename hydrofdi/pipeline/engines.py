"""The choice of an engine."""

from __future__ import annotations

from hydrofdi.errors import ConfigError
from hydrofdi.execution import Engine, InProcessEngine, LocalPoolEngine, available_cores

ENGINES = ("local", "in-process", "dask")


def make_engine(name: str, workers: int | None, scheduler: str | None, *, shared_directory: bool) -> Engine:
    """An engine by its name.

    Parameters
    ----------
    name : str
        ``local``, ``in-process`` or ``dask``.
    workers : int or None
        Processes of the local pool; by default the cores that this process may use.
    scheduler : str or None
        Address of a Dask scheduler.
    shared_directory : bool
        Whether Dask workers reach the folder of the results.

    Raises
    ------
    ConfigError
        The options do not fit the engine, or Dask is not installed.
    """
    if name == "dask":
        if not isinstance(scheduler, str):
            raise ConfigError("the engine dask needs scheduler=tcp://host:port")
        from hydrofdi.execution.dask_cluster import DaskEngine

        return DaskEngine(scheduler, shared_directory=shared_directory)
    if scheduler is not None or not shared_directory:
        raise ConfigError("scheduler and shared_directory need engine=dask")
    return InProcessEngine() if name == "in-process" else LocalPoolEngine(workers or available_cores())
