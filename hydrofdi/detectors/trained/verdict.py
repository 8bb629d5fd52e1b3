"""What a trained detector says of a window."""

from __future__ import annotations

from dataclasses import dataclass

from hydrofdi.records.streams import WindowFault


@dataclass(frozen=True)
class Verdict:
    """What a trained detector says of one window.

    Attributes
    ----------
    score : float or None
        The output of the indicator, in its unit; None if it has none. It is there for novel windows too.
    alarm : bool or None
        None if the window is not judged.
    margin : float or None
        Distance to the nearest limit in healthy spreads; negative beyond it. It is there with the score.
    fault : WindowFault or None
        Why the window is not judged.
    """

    score: float | None
    alarm: bool | None
    margin: float | None
    fault: WindowFault | None = None

    @property
    def is_beyond(self) -> bool | None:
        """Whether the score is beyond a limit, also where that is no alarm; None if there is no score."""
        return None if self.margin is None else self.margin < 0.0
