"""The figures of the paper's study."""
