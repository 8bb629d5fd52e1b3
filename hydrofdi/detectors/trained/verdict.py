"""Verdict of a trained detector on a window."""

from __future__ import annotations

from dataclasses import dataclass

from hydrofdi.errors import Issue


@dataclass(frozen=True)
class Verdict:
    """Verdict of a trained detector on one window.

    Attributes
    ----------
    score : float or None
        Output of the indicator, in its unit; None if it has none. Novel windows have a score too.
    alarm : bool or None
        Whether the window raises an alarm; None if it is not judged.
    margin : float or None
        Distance to the nearest limit in healthy spreads, negative beyond it; None if there is no score.
    fault : Issue or None
        Why the window is not judged.
    doubt : str
        Why the verdict is doubtful, which it remains all the same; empty if it is not.
    """

    score: float | None
    alarm: bool | None
    margin: float | None
    fault: Issue | None = None
    doubt: str = ""

    @property
    def is_beyond(self) -> bool | None:
        """Whether the score is beyond a limit, even if that is not an alarm; None if there is no score."""
        return None if self.margin is None else self.margin < 0.0
