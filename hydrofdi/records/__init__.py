"""Records: sampled channels of an actuator, from any source. They do not contain its true parameters."""

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array, Channel, RecordBatch, RecordSource, RejectedRecord

__all__ = ["Array", "Channel", "Issue", "RecordBatch", "RecordSource", "RejectedRecord"]
