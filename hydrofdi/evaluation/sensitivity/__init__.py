"""Sensitivity of scores to nuisances: individual spread, Sobol indices, and equivalent leak."""
