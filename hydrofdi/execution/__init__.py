"""Where and how jobs are run."""

from hydrofdi.execution.batching import split_jobs
from hydrofdi.execution.calibrating import leakage_coefficients, unsolved_conditions
from hydrofdi.execution.compute import Batch, BatchReceipt, compute_columns
from hydrofdi.execution.engine import Engine, InProcessEngine
from hydrofdi.execution.interruption import Interruption
from hydrofdi.execution.jobs import Job
from hydrofdi.execution.local_pool import LocalPoolEngine, available_cores
from hydrofdi.execution.measuring import needed_signals
from hydrofdi.execution.running import JobFailure, run_batches

__all__ = [
    "Batch",
    "BatchReceipt",
    "Engine",
    "InProcessEngine",
    "Interruption",
    "Job",
    "JobFailure",
    "LocalPoolEngine",
    "available_cores",
    "compute_columns",
    "leakage_coefficients",
    "needed_signals",
    "run_batches",
    "split_jobs",
    "unsolved_conditions",
]
