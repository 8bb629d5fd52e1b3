"""Records: sampled channels of an actuator, whoever made them. Nothing here knows the truth behind them."""

from hydrofdi.records.batch import Array, RecordBatch, RejectedRecord, Remark
from hydrofdi.records.channels import Channel
from hydrofdi.records.source import RecordSource

__all__ = ["Array", "Channel", "RecordBatch", "RecordSource", "RejectedRecord", "Remark"]
