"""Trained detectors: training results of healthy records, stored in a readable file."""
