"""The severity that is detected with a stated probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class DetectableSeverity:
    """A severity, or on which side of the tested ones it is: never an extrapolated number.

    Attributes
    ----------
    place : str
        ``within`` the tested severities, ``below`` them (it is at most the smallest) or ``above`` (not
        detectable up to the largest).
    severity : float
        Itself, or the smallest or largest tested one [unit of the severity].
    probability : float
        Of detection.
    confidence : float or None
        That the severity is no larger; None for the estimate itself.
    source : str
        Whether it is that of a fitted ``curve``, or comes from the tested ``levels`` alone.
    """

    place: Literal["below", "within", "above"]
    severity: float
    probability: float
    confidence: float | None = None
    source: Literal["curve", "levels"] = "curve"

    @property
    def value(self) -> float | None:
        """The severity that is detected with at least this probability; None if none of the tested is."""
        return None if self.place == "above" else self.severity

    def sentence(self, unit: str = "", scale: float = 1.0) -> str:
        """The severity for a person.

        Parameters
        ----------
        unit : str
        scale : float
            Multiplies the severity to give that unit.
        """
        number = f"{self.severity * scale:.3g} {unit}".rstrip()
        words = {"below": f"at most {number}", "within": number, "above": f"not detectable up to {number}"}
        return words[self.place]
