"""Model-based estimators: samples in, estimates out, with the state in arrays."""
