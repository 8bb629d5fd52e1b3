"""Parts of a sweep, for many machines that share a folder."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from hydrofdi.api.arguments import refusal
from hydrofdi.simulation.kernels.lanes import WIDTH


class Part(NamedTuple):
    """A share of a sweep: every so many blocks of its runs, whatever is stored."""

    number: int = 1
    of: int = 1

    @property
    def suffix(self) -> str:
        """What the names of its own files end in; empty for the whole."""
        return f"-{self.number}-of-{self.of}" if self.of > 1 else ""

    def positions(self, n_run: int) -> list[int]:
        """Positions of its runs among all."""
        return [k for k in range(n_run) if k // WIDTH % self.of == self.number - 1]


WHOLE = Part()


def part_of(given: Any) -> Part:
    """A part such as ``3/64``."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", given) if isinstance(given, str) else None
    part = Part(*map(int, found.groups())) if found else Part(0)
    if not 1 <= part.number <= part.of:
        raise refusal("part", "a number of so many, from 1 on, such as '3/64'", given)
    return part
