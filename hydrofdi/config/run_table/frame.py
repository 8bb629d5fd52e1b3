"""Parameters of many runs, as numbers of the sections that they share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.parameters import section_text
from hydrofdi.config.request import RunRequest
from hydrofdi.settings.quantities import Section

_CHUNK = 65_536
"""Runs whose texts are gathered at a time."""


class SectionPool:
    """The different contents of one section."""

    def __init__(self, section: Section) -> None:
        self.sections = [section]
        self._ids = {section.stated_text: 0}

    def number(self, section: Section) -> int:
        """Number of a section; a new one is kept."""
        number = self._ids.setdefault(section.stated_text, len(self.sections))
        if number == len(self.sections):
            self.sections.append(section)
        return number


@dataclass(frozen=True)
class Frame:
    """Parameters of many runs, as numbers of their sections.

    Attributes
    ----------
    base : RunRequest
        Has the sections that are the same in all runs.
    pools : dict
        Name of a section that varies → its different contents.
    numbers : array of int, shape (n_run, n_pool)
        Which of them each run has.
    """

    base: RunRequest
    pools: dict[str, SectionPool]
    numbers: NDArray[np.int32]

    def request(self, row: int) -> RunRequest:
        """The parameters of one run."""
        row_numbers = self.numbers[row].tolist()
        return self.base.with_valid_sections(
            {
                name: pool.sections[number]
                for (name, pool), number in zip(self.pools.items(), row_numbers, strict=True)
            }
        )

    def column(self, section: str) -> NDArray[np.int32]:
        """Which contents of a section each run has."""
        if section not in self.pools:
            return np.zeros(len(self.numbers), dtype=np.int32)
        return self.numbers[:, list(self.pools).index(section)]

    def texts(self, sections: Iterable[str]) -> Iterator[str]:
        """What differs from the defaults in some sections of each run, as JSON: `sections_text` of all."""
        names = sorted(sections)
        pools = {name: [getattr(self.base, name)] for name in names}
        pools |= {name: pool.sections for name, pool in self.pools.items() if name in pools}
        parts = [[section_text(name, section) for section in pools[name]] for name in names]
        columns = [self.column(name) for name in names]
        held = [k for k, part in enumerate(parts) if part != [""]]
        for first in range(0, len(self.numbers), _CHUNK):
            chosen = [[parts[k][i] for i in columns[k][first : first + _CHUNK].tolist()] for k in held]
            n_row = min(_CHUNK, len(self.numbers) - first)
            for texts in zip(*chosen, strict=True) if held else repeat((), n_row):
                yield "{" + ",".join(filter(None, texts)) + "}"
