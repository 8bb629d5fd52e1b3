"""The study as plain data."""
