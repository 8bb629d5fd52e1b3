"""Where and how jobs are run."""

from hydrofdi.execution.calibrating import leakage_coefficients, unsolved_conditions
from hydrofdi.execution.compute import (
    Batch,
    BatchReceipt,
    Job,
    compute_columns,
    needed_signals,
    run_batches,
    split_jobs,
)
from hydrofdi.execution.engine import Engine, InProcessEngine, LocalPoolEngine, available_cores

__all__ = [
    "Batch",
    "BatchReceipt",
    "Engine",
    "InProcessEngine",
    "Job",
    "LocalPoolEngine",
    "available_cores",
    "compute_columns",
    "leakage_coefficients",
    "needed_signals",
    "run_batches",
    "split_jobs",
    "unsolved_conditions",
]
