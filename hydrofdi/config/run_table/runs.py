"""Runs that share their sections: a table of numbers, from which a run is made on demand."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DEFAULT_CHOICE, Analysis, IndicatorChoice
from hydrofdi.config.request import (
    ANALYSIS_SECTIONS,
    RECORD_SECTIONS,
    RunParameters,
    RunRequest,
    section_text,
    sections_text,
)
from hydrofdi.config.sweeps.sweep import distinct_rows
from hydrofdi.physics import PHYSICS_VERSION
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
    """Parameters of many runs: which of the contents of each varying section (a pool) each run has."""

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


NONE = -1
"""Stands for a calibration that a run does not need."""


@dataclass(frozen=True, eq=False)
class RunSpec:
    """One resolved run; `calibration` has the conditions under which K_i is solved, if it is."""

    request: RunRequest
    calibration: RunParameters | None = None
    choice: IndicatorChoice = DEFAULT_CHOICE

    @cached_property
    def parameters(self) -> RunParameters:
        """All that determines its record."""
        return self.request.parameters

    @cached_property
    def analysis(self) -> Analysis:
        """What is measured of its record."""
        return Analysis(self.request.n_discarded, self.request.wavelet, self.choice)

    @property
    def record_digest(self) -> bytes:
        """SHA-256 of what determines the record, as canonical JSON in SI."""
        calibration = None if self.calibration is None else self.calibration.text()
        return _digest(calibration, self.request.text())

    @property
    def analysis_text(self) -> str:
        """What differs from the default analysis, as canonical JSON; empty if nothing does."""
        sections = {name: getattr(self.request, name) for name in ANALYSIS_SECTIONS}
        return _analysis_text(sections_text(sections), self.choice)


def _analysis_text(sections: str, choice: IndicatorChoice) -> str:
    return "" if sections == "{}" and not choice.identity else f"{sections}{choice.identity}"


def _digest(calibration: str | None, parameters: str) -> bytes:
    request = f'{{"calibration":{calibration or "null"},"parameters":{parameters}}}'
    return hashlib.sha256(request.encode()).digest()


class Runs(Sequence[RunSpec]):
    """Runs in their order, each made on demand."""

    def __init__(self, frame: Frame, calibrations: Frame, choice: IndicatorChoice = DEFAULT_CHOICE) -> None:
        self._frame, self._calibrations, self.choice = frame, calibrations, choice
        self._made: dict[bytes, RunParameters] = {}

    def __len__(self) -> int:
        return len(self._frame.numbers)

    @overload
    def __getitem__(self, index: int) -> RunSpec: ...
    @overload
    def __getitem__(self, index: slice) -> Runs: ...
    def __getitem__(self, index: int | slice) -> RunSpec | Runs:
        if isinstance(index, slice):
            return self.at(np.arange(len(self))[index])
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        return RunSpec(self._frame.request(index), self._calibration(index), self.choice)

    def _calibration(self, row: int) -> RunParameters | None:
        numbers = self._calibrations.numbers[row]
        if numbers[0] == NONE:
            return None
        key = numbers.tobytes()
        if key not in self._made:
            if len(self._made) >= _MOST_MADE:
                self._made.clear()
            self._made[key] = self._calibrations.request(row).parameters
        return self._made[key]

    def __iter__(self) -> Iterator[RunSpec]:
        return (self[row] for row in range(len(self)))

    def at(self, positions: Any) -> Runs:
        """Some of the runs."""
        rows = np.asarray(positions, dtype=np.intp)
        frame, calibrations = (
            Frame(frame.base, frame.pools, frame.numbers[rows]) for frame in (self._frame, self._calibrations)
        )
        return Runs(frame, calibrations, self.choice)

    def distinct(self, *sections: str) -> Iterator[RunRequest]:
        """One run for each combination of some sections that occurs, in order of appearance."""
        return (self._frame.request(row) for row in self.first(*sections).tolist())

    def first(self, *sections: str) -> NDArray[np.intp]:
        """The first run of each combination of some sections that occurs."""
        columns = [self._frame.column(section) for section in sections if section in self._frame.pools]
        return distinct_rows(columns, len(self))[0]

    def values(self, name: str) -> list[Any]:
        """The value of a dotted parameter in each run."""
        section, field = name.split(".")
        pool = self._frame.pools.get(section)
        sections = pool.sections if pool else [getattr(self._frame.base, section)]
        values = [getattr(content, field) for content in sections]
        return [values[number] for number in self._frame.column(section).tolist()]

    def solutions(self) -> dict[str, int]:
        """How often K_i is solved: leakage ``flows``, other ``conditions``, and the ``total`` of both."""
        calibrations = self._calibrations
        needed = np.flatnonzero(calibrations.numbers[:, 0] != NONE)
        columns = {name: calibrations.column(name)[needed] for name in calibrations.pools}
        total = distinct_rows(list(columns.values()), len(needed))[0]
        conditions = [column for name, column in columns.items() if name != "leakage"]
        return {
            "flows": len({self[row].parameters.leakage.internal_flow for row in needed[total].tolist()}),
            "conditions": len(distinct_rows(conditions, len(needed))[0]),
            "total": len(total),
        }

    def record_digests(self) -> Iterator[bytes]:
        """``RunSpec.record_digest`` of all runs."""
        solved = self._calibrations.numbers[:, 0] != NONE
        calibrations = Frame(
            self._calibrations.base, self._calibrations.pools, self._calibrations.numbers[solved]
        ).texts(RECORD_SECTIONS)
        for needs, parameters in zip(solved.tolist(), self._frame.texts(RECORD_SECTIONS), strict=True):
            yield _digest(next(calibrations) if needs else None, parameters)

    def analysis_texts(self) -> Iterator[str]:
        """``RunSpec.analysis_text`` of all runs."""
        for sections in self._frame.texts(ANALYSIS_SECTIONS):
            yield _analysis_text(sections, self.choice)


def spread(n: int, most: int) -> list[int]:
    """At most so many of the places 0 … n − 1, spread evenly, with the first and the last."""
    places: list[int] = np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int)).tolist()
    return places


_MOST_MADE = 8192
"""Calibrations that are kept so that runs share them."""


def record_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """Hash of the physics version and all that determines a record, but not of its analysis."""
    return _of_record(run.record_digest, physics_version)


def run_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """Hash of a run's record and its analysis; the identity of the record if that is the default."""
    return _of_run(record_identity(run, physics_version), run.analysis_text)


def record_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``record_identity`` of many runs."""
    return tuple([_of_record(digest, physics_version) for digest in runs.record_digests()])


def run_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``run_identity`` of many runs."""
    return identities_of_analyses(runs, record_identities(runs, physics_version))


def identities_of_analyses(runs: Runs, records: tuple[str, ...]) -> tuple[str, ...]:
    """``run_identity`` of many runs, from the identities of their records."""
    if not any(
        RunSpec(request, None, runs.choice).analysis_text for request in runs.distinct(*ANALYSIS_SECTIONS)
    ):
        return records
    return tuple([_of_run(*pair) for pair in zip(records, runs.analysis_texts(), strict=True)])


def _of_record(digest: bytes, physics_version: int) -> str:
    return hashlib.sha256(b"hydrofdi physics %d\n" % physics_version + digest).hexdigest()[:16]


def _of_run(record_id: str, analysis: str) -> str:
    if not analysis:
        return record_id
    return hashlib.sha256(f"hydrofdi run\n{record_id}\n{analysis}".encode()).hexdigest()[:16]
