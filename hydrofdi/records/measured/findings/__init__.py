"""What is found in records: defects of their channels, hum, outliers."""
