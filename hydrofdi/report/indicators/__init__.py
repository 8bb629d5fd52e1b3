"""Indicators over the runs of an experiment: changes over varied parameters, compared with healthy runs."""
