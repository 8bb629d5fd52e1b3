"""Records: sampled channels of an actuator, from any source. They do not contain its true parameters."""

from hydrofdi.records.batch import Array, RecordBatch, RejectedRecord, Remark
from hydrofdi.records.channels import Channel
from hydrofdi.records.source import RecordSource

__all__ = ["Array", "Channel", "RecordBatch", "RecordSource", "RejectedRecord", "Remark"]
