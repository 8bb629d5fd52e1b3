"""The report of a study of detection: what a judged study says, as sections, plain data and columns."""
