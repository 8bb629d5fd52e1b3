"""The built-in indicators."""
