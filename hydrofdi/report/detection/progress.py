"""Progress of a study."""

from __future__ import annotations

from dataclasses import dataclass

from hydrofdi.report.document import Block
from hydrofdi.settings.counting import counted


@dataclass(frozen=True)
class Progress:
    """Runs of a study that are computed, and those that are planned."""

    n_computed: int
    n_planned: int

    @property
    def is_complete(self) -> bool:
        """Whether no run is left to compute."""
        return self.n_computed == self.n_planned

    @property
    def record(self) -> dict[str, int]:
        """The numbers for JSON."""
        return {"runs_computed": self.n_computed, "runs_planned": self.n_planned}

    def block(self) -> Block | None:
        """The first section while runs are missing; None if no run is missing."""
        if self.is_complete:
            return None
        sentence = (
            f"{self.n_computed:,} of {counted(self.n_planned, 'run')} are computed;"
            f" 'hydrofdi sweep CONFIG' computes the rest."
        )
        so_far = " The tables show the runs so far; no conclusions are drawn from them."
        return Block("progress", "Not finished", (sentence + (so_far if self.n_computed else ""),))
