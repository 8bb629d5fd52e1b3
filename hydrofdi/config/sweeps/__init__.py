"""What an experiment varies: grids, samples, conditions and replicates."""
