"""The contents of a result file and their names."""
