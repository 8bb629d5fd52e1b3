"""What the folder of an experiment holds beside its results."""
