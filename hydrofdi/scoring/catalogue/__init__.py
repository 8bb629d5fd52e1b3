"""The scores of this package: one module each, named like its score, and found by that name."""
