"""Statistics of detection: false alarms, ROC, probability of detection. It sees only arrays of scores.

What it states are frozen dataclasses with intervals. What the records do not carry is refused, with what
would help (`NotStatedError`).
"""
