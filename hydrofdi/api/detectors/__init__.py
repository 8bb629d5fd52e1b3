"""Detectors that are trained, and judge records and streams."""
