"""The runs of an experiment as rows."""
