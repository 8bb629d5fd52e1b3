"""The model-based indicators: one module each, with the name of the indicator."""
