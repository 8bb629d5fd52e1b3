"""Results on disk: shards written by workers, and the experiment file built from them."""

from hydrofdi.store.experiment_file import ShardColumns, write_experiment
from hydrofdi.store.reading import ExperimentData, read_experiment
from hydrofdi.store.shard import Columns, ShardRow, index_shards, shard_path, write_shard

__all__ = [
    "Columns",
    "ExperimentData",
    "ShardColumns",
    "ShardRow",
    "index_shards",
    "read_experiment",
    "shard_path",
    "write_experiment",
    "write_shard",
]
