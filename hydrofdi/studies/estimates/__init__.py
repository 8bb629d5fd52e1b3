"""Accuracy of estimates of known quantities: errors and coverage of intervals."""
