"""Runs as a table with one column per varied parameter, from which a run is made on demand."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
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
    replace_fields,
    section_text,
    sections_text,
)
from hydrofdi.config.sweeps.sweep import distinct_rows
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.settings.quantities import Section


@dataclass(frozen=True, eq=False)
class ParameterTable:
    """Parameters of many runs: those of `base`, and a column for each parameter that varies.

    Attributes
    ----------
    values : dict
        Dotted parameter → its different values in SI; those of a section stand together.
    numbers : array of int, shape (n_run, n_parameter)
        Which of its values each parameter has in each run.
    made : dict
        Section and numbers of its values → the section, made once for all tables with these values.
    """

    base: RunRequest
    values: dict[str, list[Any]]
    numbers: NDArray[np.int32]
    made: dict[tuple[str, bytes], Section] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.numbers)

    def at(self, rows: NDArray[Any]) -> ParameterTable:
        """The parameters of some of the runs."""
        return replace(self, numbers=self.numbers[rows])

    @cached_property
    def _places(self) -> dict[str, slice]:
        """Section that varies → its columns."""
        owners = [name.partition(".")[0] for name in self.values]
        first = {owner: owners.index(owner) for owner in owners}
        return {owner: slice(place, place + owners.count(owner)) for owner, place in first.items()}

    def section(self, name: str, row: int) -> Section:
        """A section of one run."""
        base: Section = self.base.__dict__[name]
        if name not in self._places:
            return base
        numbers = self.numbers[row, self._places[name]]
        key = name, numbers.tobytes()
        if key not in self.made:
            varied = [*self.values.items()][self._places[name]]
            fields = (
                (parameter.partition(".")[2], values[number])
                for (parameter, values), number in zip(varied, numbers.tolist(), strict=True)
            )
            self.made[key] = replace_fields(base, tuple(fields))
        return self.made[key]

    def request(self, row: int) -> RunRequest:
        """The parameters of one run."""
        return self.base.with_valid_sections({name: self.section(name, row) for name in self._places})

    def distinct(self, *sections: str) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The first run of each combination of some sections that occurs, and which of these each run has."""
        columns = [
            column
            for name in sections
            if name in self._places
            for column in self.numbers[:, self._places[name]].T
        ]
        return distinct_rows(columns, len(self))

    def column(self, name: str) -> list[Any]:
        """The value of a dotted parameter in each run."""
        if name not in self.values:
            return [self.base.value(name)] * len(self)
        values = self.values[name]
        return [values[number] for number in self.numbers[:, list(self.values).index(name)].tolist()]

    def texts(self, sections: Iterable[str]) -> Iterator[str]:
        """What differs from the defaults in some sections of each run, as JSON: `sections_text` of all."""
        columns = []
        for name in sorted(sections):
            first, which = self.distinct(name)
            texts = [section_text(name, self.section(name, row)) for row in first.tolist()]
            if any(texts):
                columns.append(map(texts.__getitem__, which))
        for parts in zip(*columns, strict=True) if columns else repeat((), len(self)):
            yield "{" + ",".join(filter(None, parts)) + "}"


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
    """Runs in their order, each made on demand; `calibration_of` is the row of `calibrations` or ``NONE``."""

    def __init__(
        self,
        table: ParameterTable,
        calibrations: ParameterTable,
        calibration_of: NDArray[np.intp],
        choice: IndicatorChoice = DEFAULT_CHOICE,
    ) -> None:
        self._table, self._calibrations, self._calibration_of = table, calibrations, calibration_of
        self.choice = choice
        self._solved: dict[int, RunParameters] = {}

    def __len__(self) -> int:
        return len(self._table)

    @overload
    def __getitem__(self, index: int) -> RunSpec: ...
    @overload
    def __getitem__(self, index: slice) -> Runs: ...
    def __getitem__(self, index: int | slice) -> RunSpec | Runs:
        if isinstance(index, slice):
            return self.at(np.arange(len(self))[index])
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        return RunSpec(self._table.request(index), self._calibration(index), self.choice)

    def _calibration(self, row: int) -> RunParameters | None:
        place = int(self._calibration_of[row])
        if place == NONE:
            return None
        if place not in self._solved:
            if len(self._solved) >= _MOST_MADE:
                self._solved.clear()
            self._solved[place] = self._calibrations.request(place).parameters
        return self._solved[place]

    def __iter__(self) -> Iterator[RunSpec]:
        return (self[row] for row in range(len(self)))

    def at(self, positions: Any) -> Runs:
        """Some of the runs."""
        rows = np.asarray(positions, dtype=np.intp)
        return Runs(self._table.at(rows), self._calibrations, self._calibration_of[rows], self.choice)

    def distinct(self, *sections: str) -> Iterator[RunRequest]:
        """One run for each combination of some sections that occurs, in order of appearance."""
        return (self._table.request(row) for row in self.first(*sections).tolist())

    def first(self, *sections: str) -> NDArray[np.intp]:
        """The first run of each combination of some sections that occurs."""
        return self._table.distinct(*sections)[0]

    def values(self, name: str) -> list[Any]:
        """The value of a dotted parameter in each run."""
        return self._table.column(name)

    def solutions(self) -> dict[str, int]:
        """How often K_i is solved: leakage ``flows``, other ``conditions``, and the ``total`` of both."""
        needed = np.unique(self._calibration_of[self._calibration_of != NONE])
        solved = self._calibrations.at(needed)
        others = [name for name in RECORD_SECTIONS if name != "leakage"]
        return {
            "flows": len(set(solved.column("leakage.internal_flow"))),
            "conditions": len(solved.distinct(*others)[0]),
            "total": len(needed),
        }

    def record_digests(self) -> Iterator[bytes]:
        """``RunSpec.record_digest`` of all runs."""
        calibrations: list[str | None] = [*self._calibrations.texts(RECORD_SECTIONS), None]
        texts = self._table.texts(RECORD_SECTIONS)
        for place, parameters in zip(self._calibration_of, texts, strict=True):
            yield _digest(calibrations[place], parameters)

    def analysis_texts(self) -> Iterator[str]:
        """``RunSpec.analysis_text`` of all runs."""
        for sections in self._table.texts(ANALYSIS_SECTIONS):
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
