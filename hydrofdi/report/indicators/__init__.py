"""Indicators over the runs of an experiment: changes over what varies, beside those of healthy runs."""
