"""Severity axis of a probability-of-detection curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.scores import Array

AxisName = Literal["log", "linear"]


@dataclass(frozen=True)
class Axis:
    """Transformation of severity: decimal logarithm, or fraction of the largest tested severity.

    Use the first for scores that grow with the logarithm of the severity, and the second for scores
    proportional to the severity, such as its estimate: MIL-HDBK-1823A (2009), appendix G.

    Attributes
    ----------
    name : str
        ``log`` or ``linear``.
    largest : float
        Largest tested severity [unit of the severity].
    """

    name: AxisName
    largest: float

    def place(self, severity: ArrayLike) -> Array:
        """Places of severities on the axis, in the same shape."""
        values = np.asarray(severity, dtype=float)
        return np.asarray(np.log10(values) if self.name == "log" else values / self.largest)

    def severity(self, place: float) -> float:
        """Severity at a place on the axis."""
        return float(10.0**place) if self.name == "log" else place * self.largest
