"""The version of hydrofdi."""

__version__ = "0.9.0"
