"""The axis of the severity along which a probability of detection rises."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.scores import Array

AxisName = Literal["log", "linear"]


@dataclass(frozen=True)
class Axis:
    """Places of severities: decimal logarithms, or shares of the largest tested one.

    A score that grows with the logarithm of the severity asks for the first, one that grows with the severity
    itself, such as an estimate of it, for the second: MIL-HDBK-1823A (2009), appendix G.

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
        """Places of severities, of their shape."""
        values = np.asarray(severity, dtype=float)
        return np.asarray(np.log10(values) if self.name == "log" else values / self.largest)

    def severity(self, place: float) -> float:
        """The severity at a place."""
        return float(10.0**place) if self.name == "log" else place * self.largest
