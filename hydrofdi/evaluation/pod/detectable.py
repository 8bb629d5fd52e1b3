"""Severity that is detected with a given probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class DetectableSeverity:
    """A severity within the tested range, or the side of the range; never extrapolated.

    Attributes
    ----------
    place : str
        ``within`` the tested severities, ``below`` them (it is at most the smallest) or ``above`` (not
        detectable up to the largest).
    severity : float
        The severity, or the smallest or largest tested one [unit of the severity].
    probability : float
        Probability of detection.
    confidence : float or None
        Confidence that the severity is not larger; None for the estimate itself.
    source : str
        Source of the value: a fitted ``curve``, or only the tested ``levels``.
    """

    place: Literal["below", "within", "above"]
    severity: float
    probability: float
    confidence: float | None = None
    source: Literal["curve", "levels"] = "curve"

    @property
    def value(self) -> float | None:
        """Severity that is detected with at least this probability; None if no tested severity is."""
        return None if self.place == "above" else self.severity

    def sentence(self, unit: str = "", scale: float = 1.0) -> str:
        """Severity as a text for readers.

        Parameters
        ----------
        unit : str
        scale : float
            Factor from the severity to this unit.
        """
        number = f"{self.severity * scale:.3g} {unit}".rstrip()
        words = {"below": f"at most {number}", "within": number, "above": f"not detectable up to {number}"}
        return words[self.place]
