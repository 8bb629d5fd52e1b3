"""The built-in indicators: one module each, with the name of the indicator."""
