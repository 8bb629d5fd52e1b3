"""Detectors: trained on healthy records, they score other records, as batches or as streams."""
