"""Estimators that know a model of the actuator: samples in, estimates out, state between them in arrays."""
