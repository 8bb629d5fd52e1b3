"""Where and how jobs are run."""

from hydrofdi.execution.batching import split_jobs
from hydrofdi.execution.compute import Batch, BatchReceipt, Job, compute_columns, compute_shard
from hydrofdi.execution.engine import Engine, InProcessEngine
from hydrofdi.execution.local_pool import LocalPoolEngine, available_cores

__all__ = [
    "Batch",
    "BatchReceipt",
    "Engine",
    "InProcessEngine",
    "Job",
    "LocalPoolEngine",
    "available_cores",
    "compute_columns",
    "compute_shard",
    "split_jobs",
]
