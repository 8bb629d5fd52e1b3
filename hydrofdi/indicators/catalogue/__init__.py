"""The indicators of this package: one module each, named like its indicator, and found by that name."""
