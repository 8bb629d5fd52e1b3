"""The stroke of a piston from its first to its last position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.recording import Recording

_MARGIN = 0.02
"""Share of the stroke at each end that does not belong to the motion."""
_NOISE = 6.0
"""A stroke is larger than this many times the noise of the position."""
_MOST_ENDS = 20


@dataclass(frozen=True)
class Stroke:
    """A motion from the first position to the last.

    Attributes
    ----------
    distance : float
        Last minus first position, in the position's unit.
    start, arrival : int
        First samples beyond 2 % and at 98 % of the distance.
    """

    distance: float
    start: int
    arrival: int

    @property
    def direction(self) -> str:
        """``+`` or ``-``."""
        return "+" if self.distance > 0.0 else "-"


def find_stroke(position: Array) -> Stroke | None:
    """The stroke in a position; None if its distance is within the noise.

    Parameters
    ----------
    position : ndarray, shape (n_time,)
    """
    n_end = min(_MOST_ENDS, max(1, position.size // 50))
    first, last = float(np.median(position[:n_end])), float(np.median(position[-n_end:]))
    noise = float(np.median(np.abs(np.diff(position)))) if position.size > 1 else 0.0
    distance = last - first
    if not abs(distance) > _NOISE * noise or not np.isfinite(distance):
        return None
    progress = (position - first) / distance
    return Stroke(distance, int(np.argmax(progress > _MARGIN)), int(np.argmax(progress >= 1.0 - _MARGIN)))


def short_stroke(recording: Recording, stroke: Stroke | None, shortest: float | None) -> tuple[Issue, ...]:
    """A remark if a stroke is too short."""
    distance = 0.0 if stroke is None else abs(stroke.distance)
    if shortest is None or distance >= shortest:
        return ()
    unit = recording.unit(Channel.PISTON_POSITION)
    return (
        Issue(f"the stroke is {distance:.4g} {unit}, less than {shortest:.4g} {unit}", kind="short_stroke"),
    )
