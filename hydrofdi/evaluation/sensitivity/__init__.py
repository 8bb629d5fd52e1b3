"""Which nuisance affects a score: spread of each alone, Sobol indices, and the equivalent leak."""
