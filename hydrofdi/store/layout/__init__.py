"""What stands in a result file, and under which names."""
