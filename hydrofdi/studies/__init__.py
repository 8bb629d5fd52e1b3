"""Studies of detection: indicators judged by thresholds on populations of records.

Here alone do scores meet what is known of their records.
"""
