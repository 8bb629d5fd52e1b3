"""The built-in scores: one module each, with the name of the score."""
