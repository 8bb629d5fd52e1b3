"""The runs that an experiment expands to."""
