"""Saturation."""

from __future__ import annotations

from hydrofdi.physics.equation import equation


@equation
def limited(value: float, limit: float) -> float:
    """The value, limited to ±limit."""
    return min(max(value, -limit), limit)
