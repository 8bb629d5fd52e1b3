"""Functional mock-up units (FMUs): what they describe, and instances of them. FMPy reads and runs them."""
