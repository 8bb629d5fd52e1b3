"""Measured files as records: described by a YAML, or plain files whose columns say what they are."""

from hydrofdi.records.measured.plain import plain_file_source, plain_files, plain_folder_source
from hydrofdi.records.measured.source import MeasuredSource, measured_source

__all__ = ["MeasuredSource", "measured_source", "plain_file_source", "plain_files", "plain_folder_source"]
