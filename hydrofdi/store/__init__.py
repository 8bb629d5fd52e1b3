"""Storage of results: shards written by workers, and the experiment file built from them."""

from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.experiment_file import write_experiment
from hydrofdi.store.folder.provenance import Failure, forget_failure, read_failures, write_failure
from hydrofdi.store.index import ShardIndex, StoredRun, holds_enough, read_index
from hydrofdi.store.reading import read_experiment, read_unfinished
from hydrofdi.store.results import ShardResults
from hydrofdi.store.shard import Columns, write_shard

__all__ = [
    "Columns",
    "ExperimentData",
    "Failure",
    "ShardIndex",
    "ShardResults",
    "StoredRun",
    "forget_failure",
    "holds_enough",
    "read_experiment",
    "read_failures",
    "read_index",
    "read_unfinished",
    "write_experiment",
    "write_failure",
    "write_shard",
]
