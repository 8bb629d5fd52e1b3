"""Who looks on while a sweep runs."""

from __future__ import annotations

from typing import Protocol

RUNS = "runs"
COEFFICIENTS = "leakage coefficients K_i solved before the runs"


class Watcher(Protocol):
    """Receives news of a sweep."""

    def begin(self, what: str, total: int) -> None:
        """So many of `what` are to be computed now: `RUNS`, or `COEFFICIENTS`."""
        ...

    def advance(self, count: int, n_failed: int = 0) -> None:
        """So many more of them ended, and so many of these failed."""
        ...

    def tell(self, message: str) -> None:
        """A line for the user."""
        ...


class Nobody:
    """A watcher who does not look."""

    def begin(self, what: str, total: int) -> None:
        """Ignore it."""

    def advance(self, count: int, n_failed: int = 0) -> None:
        """Ignore it."""

    def tell(self, message: str) -> None:
        """Ignore it."""
