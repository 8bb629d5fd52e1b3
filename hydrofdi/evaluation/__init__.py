"""Detection statistics: false alarms, ROC, probability of detection, from arrays of scores.

Results are frozen dataclasses with intervals. If the records do not support a result, `NotStatedError` says
why, and what would help.
"""
