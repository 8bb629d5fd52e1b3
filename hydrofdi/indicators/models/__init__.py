"""Indicators that know a model of the actuator, one module each, found by name."""
