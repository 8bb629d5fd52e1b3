"""Measured files as records: described by a YAML file, or plain files whose headers name the channels."""

from hydrofdi.records.measured.source import (
    MeasuredSource,
    measured_source,
    plain_file_source,
    plain_files,
    plain_folder_source,
)

__all__ = ["MeasuredSource", "measured_source", "plain_file_source", "plain_files", "plain_folder_source"]
