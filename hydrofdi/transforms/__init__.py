"""Transforms of sampled signals: wavelets, spectra, and changes relative to a baseline."""
