"""Statistics of detection: false alarms, ROC, probability of detection. It knows arrays of scores alone.

What it states are frozen dataclasses with intervals. What the records do not carry is refused, with what
would help (`NotStatedError`).
"""
