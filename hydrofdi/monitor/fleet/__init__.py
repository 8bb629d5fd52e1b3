"""One process that monitors many machines: one state, one log, one place for metrics."""
