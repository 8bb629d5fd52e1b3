"""Observers of the chamber pressures, with valve and actuator parameters from the data sheet."""
