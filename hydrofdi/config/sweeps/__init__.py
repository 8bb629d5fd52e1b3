"""What an experiment varies: grids, samples and conditions."""
