"""Engines by their names."""

from hydrofdi.engine import Engine, InProcessEngine, LocalPoolEngine, available_cores
from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import nearest


def engine_named(
    name: str, workers: int | None, scheduler: str | None, *, shared_directory: bool = True
) -> Engine:
    """An engine by its name; `workers` of a local pool are by default the cores that this process may use."""
    if name not in (known := ("local", "in-process", "dask")):
        raise ConfigError(f"engine: {name!r} is unknown{nearest(str(name), known)}")
    if name == "dask":
        if not isinstance(scheduler, str):
            raise ConfigError("the engine dask needs scheduler=tcp://host:port")
        from hydrofdi.execution.dask_cluster import DaskEngine

        return DaskEngine(scheduler, shared_directory=shared_directory)
    if scheduler is not None or not shared_directory:
        raise ConfigError("scheduler and shared_directory need engine=dask")
    return InProcessEngine() if name == "in-process" else LocalPoolEngine(workers or available_cores())
