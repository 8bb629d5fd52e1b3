"""The end of a decay."""

from __future__ import annotations

from hydrofdi.physics.equation import equation

NEGLIGIBLE = 1e-100
"""Size below which a state counts as zero, in its SI unit; no unit makes such a number mean anything.

A decay that never ends reaches subnormal numbers (below 2e-308), with which many processors are some fifty
times slower. The distance leaves room for the products of states and small parameters."""


@equation
def settled(value: float) -> float:
    """A state, or zero if it is negligible; NaN stays NaN."""
    return 0.0 if abs(value) < NEGLIGIBLE else value
