"""What can be said of an experiment before it is run in earnest, and the leakages that it asks for."""
