"""Rounding of negligible states to zero."""

from __future__ import annotations

from hydrofdi.physics.equation import equation

NEGLIGIBLE = 1e-100
"""Absolute value below which a state counts as zero, in its SI unit.

An exponential decay ends in subnormal numbers (below 2e-308), which many processors handle about fifty times
more slowly. The margin covers products of states and small parameters.
"""


@equation
def settled(value: float) -> float:
    """The state, or zero if it is negligible; NaN stays NaN."""
    return 0.0 if abs(value) < NEGLIGIBLE else value
