"""Probability of detection (POD) over the severity of a fault."""
