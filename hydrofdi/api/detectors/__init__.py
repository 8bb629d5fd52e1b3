"""Detectors: trained, and judging records and streams."""
