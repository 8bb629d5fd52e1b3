"""Results of the control charts of a study, as a section, plain data and columns."""
