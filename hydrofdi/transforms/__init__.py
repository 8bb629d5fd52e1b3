"""Transforms of a sampled signal: wavelets, spectra, and changes against a baseline."""
