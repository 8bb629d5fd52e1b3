"""What control charts say of a study, as a section, plain data and columns."""
