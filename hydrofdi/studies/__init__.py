"""Studies of detection: what the records of populations, judged by thresholds, say of indicators.

Here alone do scores meet what is known of their records.
"""
