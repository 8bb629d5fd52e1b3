"""Detectors: what learns from healthy records and scores others, whole or as they come."""
