"""Layout of result files: variables and their names."""
