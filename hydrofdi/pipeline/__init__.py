"""From an experiment to stored results, and back: the stages that commands are made of."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrofdi.pipeline.inspecting import explain, recompute, sweep_status, verify
    from hydrofdi.pipeline.places import experiment_directory
    from hydrofdi.pipeline.planning import SweepPlan, plan_sweep, predict_seconds
    from hydrofdi.pipeline.results import read_results
    from hydrofdi.pipeline.single import SingleRun, simulate_nominal, write_single_run
    from hydrofdi.pipeline.sweeping import SweepSummary, collect, run_sweep

_HOMES = {
    "SingleRun": "hydrofdi.pipeline.single",
    "SweepPlan": "hydrofdi.pipeline.planning",
    "SweepSummary": "hydrofdi.pipeline.sweeping",
    "collect": "hydrofdi.pipeline.sweeping",
    "experiment_directory": "hydrofdi.pipeline.places",
    "explain": "hydrofdi.pipeline.inspecting",
    "plan_sweep": "hydrofdi.pipeline.planning",
    "predict_seconds": "hydrofdi.pipeline.planning",
    "read_results": "hydrofdi.pipeline.results",
    "recompute": "hydrofdi.pipeline.inspecting",
    "run_sweep": "hydrofdi.pipeline.sweeping",
    "simulate_nominal": "hydrofdi.pipeline.single",
    "sweep_status": "hydrofdi.pipeline.inspecting",
    "verify": "hydrofdi.pipeline.inspecting",
    "write_single_run": "hydrofdi.pipeline.single",
}
"""Name → module that it is loaded from when it is first used, so that commands load what they need."""

__all__ = [
    "SingleRun",
    "SweepPlan",
    "SweepSummary",
    "collect",
    "experiment_directory",
    "explain",
    "plan_sweep",
    "predict_seconds",
    "read_results",
    "recompute",
    "run_sweep",
    "simulate_nominal",
    "sweep_status",
    "verify",
    "write_single_run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
