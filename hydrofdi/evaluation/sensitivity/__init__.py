"""Which nuisance moves a score: spreads of one alone, Sobol indices, and what a leak would have to be."""
