"""Measured files as records: described by a YAML file, or plain files whose headers name the channels."""
