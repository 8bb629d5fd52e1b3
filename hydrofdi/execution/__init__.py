"""Where and how jobs are run."""

from hydrofdi.engine import Engine, InProcessEngine, LocalPoolEngine, available_cores
from hydrofdi.errors import ConfigError
from hydrofdi.execution.compute import (
    Batch,
    Job,
    Recorder,
    compute_columns,
    needed_signals,
    run_jobs,
    split_jobs,
)
from hydrofdi.settings.messages import nearest
from hydrofdi.simulation.calibration import leakage_coefficients, unsolved_conditions

__all__ = [
    "Batch",
    "Engine",
    "InProcessEngine",
    "Job",
    "LocalPoolEngine",
    "Recorder",
    "available_cores",
    "compute_columns",
    "engine_named",
    "leakage_coefficients",
    "needed_signals",
    "run_jobs",
    "split_jobs",
    "unsolved_conditions",
]


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
