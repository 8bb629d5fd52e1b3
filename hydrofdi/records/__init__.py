"""Records: sampled channels of an actuator, from any source. They do not contain its true parameters."""

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array, RecordBatch, RecordSource, RejectedRecord
from hydrofdi.records.channels import Channel

__all__ = ["Array", "Channel", "Issue", "RecordBatch", "RecordSource", "RejectedRecord"]
