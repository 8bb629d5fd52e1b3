"""Simulation: from resolved runs to sampled signals."""
