"""The version of hydrofdi."""

__version__ = "0.1.0"
