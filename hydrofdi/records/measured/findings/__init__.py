"""Findings in records: defects of their channels, hum, outliers."""
