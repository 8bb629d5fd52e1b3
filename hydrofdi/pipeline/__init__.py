"""From an experiment to stored results, and back: the stages that commands are made of."""

from hydrofdi.pipeline.inspecting import explain, recompute, sweep_status, verify
from hydrofdi.pipeline.places import experiment_directory
from hydrofdi.pipeline.planning import SweepPlan, plan_sweep, predict
from hydrofdi.pipeline.results import read_results
from hydrofdi.pipeline.single import SingleRun, simulate_nominal, write_single_run
from hydrofdi.pipeline.sweeping import SweepSummary, collect, run_sweep

__all__ = [
    "SingleRun",
    "SweepPlan",
    "SweepSummary",
    "collect",
    "experiment_directory",
    "explain",
    "plan_sweep",
    "predict",
    "read_results",
    "recompute",
    "run_sweep",
    "simulate_nominal",
    "sweep_status",
    "verify",
    "write_single_run",
]
