"""Observers of the chamber pressures, which take valve and actuator from the data sheet."""
