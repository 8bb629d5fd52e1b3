"""Contents of an experiment's folder besides its results."""
