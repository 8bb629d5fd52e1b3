"""An experiment → its runs: a table with one column per varied parameter, from which a run is made on demand.

Each run has the conditions under which its K_i is solved, its healthy baselines, and its identity.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import repeat
from typing import Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.drive import digest
from hydrofdi.config.experiment import (
    DEFAULT_CHOICE,
    INTERNAL_LEAKAGE_FORMS,
    Analysis,
    ExperimentConfig,
    IndicatorChoice,
)
from hydrofdi.config.machine import LeakageConfig
from hydrofdi.config.plant import declare, is_foreign
from hydrofdi.config.request import (
    ANALYSIS_SECTIONS,
    OBSERVATION,
    RECORD_SECTIONS,
    RunParameters,
    RunRequest,
    parameter_names,
    replace_fields,
    section_text,
    sections_text,
)
from hydrofdi.config.study import StudyConfig, StudyTable, populations, study_points, study_table
from hydrofdi.config.sweep import NOMINAL, Points, count_points, distinct_rows, multiplied, sweep_points
from hydrofdi.config.values import shown_values
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import counted, first_reason
from hydrofdi.settings.quantities import Section

PHYSICS_VERSION = 4
"""Version of everything that determines the results of a run (equations, kernel, features, defaults).

It is part of every run's identity: raise it when results change, and stored runs are computed again.
"""


@dataclass(frozen=True, eq=False)
class ParameterTable:
    """Parameters of many runs: those of `base`, and a column for each parameter that varies.

    Attributes
    ----------
    choices : dict
        Dotted parameter → its different values in SI; those of a section stand together.
    numbers : array of int, shape (n_run, n_parameter)
        Which of its values each parameter has in each run.
    made : dict
        Section and numbers of its values → the section, made once for all tables with these values.
    """

    base: RunRequest
    choices: dict[str, list[Any]]
    numbers: NDArray[np.int32]
    made: dict[tuple[str, bytes], Section] = field(default_factory=dict, kw_only=True)

    def __len__(self) -> int:
        return len(self.numbers)

    def at(self, rows: Any) -> Self:
        """Some of the runs."""
        return replace(self, numbers=self.numbers[rows])

    @cached_property
    def _columns(self) -> dict[str, slice]:
        """Section that varies → its columns."""
        owners = [name.partition(".")[0] for name in self.choices]
        first = {owner: owners.index(owner) for owner in owners}
        return {owner: slice(column, column + owners.count(owner)) for owner, column in first.items()}

    def section(self, name: str, row: int) -> Section:
        """A section of one run."""
        base: Section = self.base.__dict__[name]
        if name not in self._columns:
            return base
        numbers = self.numbers[row, self._columns[name]]
        key = name, numbers.tobytes()
        if key not in self.made:
            varied = [*self.choices.items()][self._columns[name]]
            fields = (
                (parameter.partition(".")[2], values[number])
                for (parameter, values), number in zip(varied, numbers.tolist(), strict=True)
            )
            self.made[key] = replace_fields(base, tuple(fields))
        return self.made[key]

    def request(self, row: int) -> RunRequest:
        """The parameters of one run."""
        return self.base.with_valid_sections({name: self.section(name, row) for name in self._columns})

    def combinations(self, *sections: str) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The first run of each combination of some sections that occurs, and which of these each run has."""
        columns = [
            column
            for name in sections
            if name in self._columns
            for column in self.numbers[:, self._columns[name]].T
        ]
        return distinct_rows(columns, len(self))

    def values(self, name: str) -> list[Any]:
        """The value of a dotted parameter in each run."""
        if name not in self.choices:
            return [self.base.value(name)] * len(self)
        values = self.choices[name]
        return [values[number] for number in self.numbers[:, list(self.choices).index(name)].tolist()]

    def texts(self, sections: Iterable[str]) -> Iterator[str]:
        """What differs from the defaults in some sections of each run, as JSON: `sections_text` of all."""
        columns = []
        for name in sorted(sections):
            first, which = self.combinations(name)
            texts = [section_text(name, self.section(name, row)) for row in first.tolist()]
            if any(texts):
                columns.append(map(texts.__getitem__, which))
        for parts in zip(*columns, strict=True) if columns else repeat((), len(self)):
            yield "{" + ",".join(filter(None, parts)) + "}"


NO_ROW = -1
"""Stands for the row of a run that does not exist, or of a calibration that a run does not need."""


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
    def analysis_text(self) -> str:
        """What differs from the default analysis, as canonical JSON; empty if nothing does."""
        sections = {name: getattr(self.request, name) for name in ANALYSIS_SECTIONS}
        return _analysis_text(sections_text(sections), self.choice)


def _analysis_text(sections: str, choice: IndicatorChoice) -> str:
    return "" if sections == "{}" and not choice.identity else f"{sections}{choice.identity}"


@dataclass(frozen=True, eq=False)
class Runs(ParameterTable, Sequence[RunSpec]):
    """Runs in their order, made on demand; `calibration_of` is the row of `calibrations` or ``NO_ROW``."""

    calibrations: ParameterTable
    calibration_of: NDArray[np.intp]
    choice: IndicatorChoice = DEFAULT_CHOICE

    @cached_property
    def _conditions(self) -> Callable[[int], RunParameters]:
        # Neighbours share their conditions.
        return lru_cache(_MOST_MADE)(lambda row: self.calibrations.request(row).parameters)

    @overload
    def __getitem__(self, index: int) -> RunSpec: ...
    @overload
    def __getitem__(self, index: slice) -> Runs: ...
    def __getitem__(self, index: int | slice) -> RunSpec | Runs:
        if isinstance(index, slice):
            return self.at(np.arange(len(self))[index])
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        row = self.calibration_of[index]
        return RunSpec(self.request(index), None if row == NO_ROW else self._conditions(row), self.choice)

    def at(self, rows: Any) -> Runs:
        """Some of the runs."""
        rows = np.asarray(rows, dtype=np.intp)
        return replace(self, numbers=self.numbers[rows], calibration_of=self.calibration_of[rows])

    def distinct(self, *sections: str) -> Iterator[RunRequest]:
        """One run for each combination of some sections that occurs, in order of appearance."""
        return (self.request(row) for row in self.first(*sections).tolist())

    def first(self, *sections: str) -> NDArray[np.intp]:
        """The first run of each combination of some sections that occurs."""
        return self.combinations(*sections)[0]

    def solutions(self) -> dict[str, int]:
        """How often K_i is solved: leakage ``flows``, other ``conditions``, and the ``total`` of both."""
        needed = np.unique(self.calibration_of[self.calibration_of != NO_ROW])
        solved = self.calibrations.at(needed)
        others = [name for name in RECORD_SECTIONS if name != "leakage"]
        return {
            "flows": len(set(solved.values("leakage.internal_flow"))),
            "conditions": len(solved.combinations(*others)[0]),
            "total": len(needed),
        }

    def record_texts(self) -> Iterator[tuple[str | None, str]]:
        """What determines the record of each run: the conditions under which K_i is solved, and itself."""
        calibrations: list[str | None] = [*self.calibrations.texts(RECORD_SECTIONS), None]
        conditions = map(calibrations.__getitem__, self.calibration_of)
        return zip(conditions, self.texts(RECORD_SECTIONS), strict=True)

    def analysis_texts(self) -> Iterator[str]:
        """``RunSpec.analysis_text`` of all runs."""
        for sections in self.texts(ANALYSIS_SECTIONS):
            yield _analysis_text(sections, self.choice)


def spread(n: int, most: int) -> list[int]:
    """At most so many of the places 0 … n − 1, spread evenly, with the first and the last."""
    positions: list[int] = np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int)).tolist()
    return positions


_MOST_MADE = 8192
"""Calibrations that are kept so that runs share them."""


def record_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """Hash of the physics version and all that determines a record, but not of its analysis."""
    calibration = None if run.calibration is None else run.calibration.text()
    return _of_record(calibration, run.request.text(), physics_version)


def run_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """Hash of a run's record and its analysis; the identity of the record if that is the default."""
    return _of_run(record_identity(run, physics_version), run.analysis_text)


def record_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``record_identity`` of many runs."""
    return tuple([_of_record(*texts, physics_version) for texts in runs.record_texts()])


def run_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``run_identity`` of many runs."""
    return identities_of_analyses(runs, record_identities(runs, physics_version))


def identities_of_analyses(runs: Runs, records: tuple[str, ...]) -> tuple[str, ...]:
    """``run_identity`` of many runs, from the identities of their records."""
    return tuple([_of_run(*pair) for pair in zip(records, runs.analysis_texts(), strict=True)])


def _of_record(calibration: str | None, parameters: str, physics_version: int) -> str:
    request = f'{{"calibration":{calibration or "null"},"parameters":{parameters}}}'
    digest = hashlib.sha256(request.encode()).digest()
    return hashlib.sha256(b"hydrofdi physics %d\n" % physics_version + digest).hexdigest()[:16]


def _of_run(record_id: str, analysis: str) -> str:
    if not analysis:
        return record_id
    return hashlib.sha256(f"hydrofdi run\n{record_id}\n{analysis}".encode()).hexdigest()[:16]


MOST_RUNS = 1_000_000
"""Points that one sweep may have."""


@dataclass(frozen=True, eq=False)
class RunTable:
    """The runs of an experiment: swept, then the healthy ones that the sweep lacks.

    Attributes
    ----------
    axes : dict
        Dotted parameter → its different values in SI, in order of appearance.
    fixed_baseline, matched_baseline : array of int, shape (n_run,)
        The healthy run to compare with: under the baseline's conditions, and under the run's own.
    study : StudyTable or None
        Who is who among the runs of a study, which have no baselines.
    """

    runs: Runs
    axes: dict[str, tuple[Any, ...]]
    n_swept: int
    fixed_baseline: NDArray[np.intp]
    matched_baseline: NDArray[np.intp]
    study: StudyTable | None = None


def expand_runs(experiment: ExperimentConfig) -> RunTable:
    """The runs of the experiment's sweep and their baselines.

    Points that ask for the same run are one run.

    Raises
    ------
    ConfigError
        A combination of swept values is impossible, or the sweep is empty or too large.
    """
    if (model := experiment.plant.model) is not None:
        declare(model)  # another experiment may have been read since
    if experiment.study is not None:
        return _expand_study(experiment, experiment.study)
    _require_countable(count_points(experiment.ensemble) * count_points(experiment.sweep))
    scenarios, swept = (_block_points(experiment, section) for section in ("ensemble", "sweep"))
    points = multiplied(scenarios, swept)
    expansion = Expansion(experiment, points)
    rows = expansion.swept_rows()
    n_swept = len(rows)
    rows, fixed, matched = expansion.with_baselines(rows)
    return RunTable(expansion.runs(rows), _axes(points), n_swept, fixed, matched)


def _expand_study(experiment: ExperimentConfig, study: StudyConfig) -> RunTable:
    """The runs of all populations, in each design."""
    n_record = sum(population.count for population in populations(study))
    _require_countable(count_points(experiment.sweep) * n_record, "study")
    points = multiplied(_block_points(experiment, "sweep"), study_points(study))
    table = study_roles(experiment)
    expansion = Expansion(experiment, points, table)
    rows = expansion.swept_rows()
    n_run = len(rows)
    if n_run < points.n_point:
        message = f"draws {counted(points.n_point - n_run, 'record')} twice; let more of them vary"
        raise ConfigError([Issue(message, "study.population")])
    none = np.full(n_run, NO_ROW)
    return RunTable(expansion.runs(rows), _axes(points), n_run, none, none, table)


def study_roles(experiment: ExperimentConfig) -> StudyTable:
    """Who is who among the runs of an experiment with a study; nothing is drawn."""
    assert experiment.study is not None
    designs = _block_points(experiment, "sweep")
    return study_table(experiment.study, [designs.values(point) for point in range(designs.n_point)])


def _require_countable(n_point: int, key: str = "sweep") -> None:
    if n_point > MOST_RUNS:
        message = f"{counted(n_point, 'run')} exceed the limit of {MOST_RUNS:,} per sweep, before 'where'"
        raise ConfigError([Issue(message, key)])


def _block_points(experiment: ExperimentConfig, section: str) -> Points:
    points = sweep_points(getattr(experiment, section), experiment.nominal_parameters.value, section)
    if not points.n_point:
        raise ConfigError([Issue("no point satisfies 'where'", section)])
    return points


def _axes(points: Points) -> dict[str, tuple[Any, ...]]:
    """Dotted parameter → its different values in order of appearance."""
    occurring = {name: dict.fromkeys(column.index.tolist()) for name, column in points.columns.items()}
    return {
        name: tuple(dict.fromkeys(points.columns[name].values[index] for index in own if index != NOMINAL))
        for name, own in occurring.items()
    }


Numbers = NDArray[np.int32]
"""Runs as numbers of the values of their parameters, shape (n_run, n_parameter)."""


class Expansion:
    """Points turned into runs: those of the sweep, their baselines, and the conditions of K_i.

    Each parameter that may vary is a column, with numbers of its different values.
    """

    def __init__(self, experiment: ExperimentConfig, points: Points, study: StudyTable | None = None) -> None:
        self._points = points
        self._study = study
        self._nominal = experiment.nominal_parameters
        self._baseline = experiment.baseline
        self._experiment = experiment
        # A sealed piston has one form: K_i = 0, and all else of the internal leakage by default.
        stated = {f"leakage.{field}": None for field in self._nominal.leakage.stated()}
        names = {*points.columns, *self._baseline, *INTERNAL_LEAKAGE_FORMS, *stated}
        plain = LeakageConfig(internal_coefficient=0.0)
        self._sealed = {
            name: getattr(plain, name.partition(".")[2])
            for name in names
            if name.startswith("leakage.") and not name.startswith("leakage.external_")
        }
        self._numbers = {
            name: _numbered(name, [
                self._nominal.value(name),
                *(points.columns[name].values if name in points.columns else ()),
                *(own[name] for own in (self._baseline, self._sealed) if name in own),
                *((None, 0.0) if name in INTERNAL_LEAKAGE_FORMS else ()),
            ])
            for name in (*parameter_names(), *sorted(filter(is_foreign, names)))
            if name in names
        }  # fmt: skip
        self._column = {name: index for index, name in enumerate(self._numbers)}
        values = {name: _first_values(numbers) for name, numbers in self._numbers.items()}
        self._table = ParameterTable(self._nominal, values, np.zeros((0, len(values)), dtype=np.int32))

    def runs(self, numbers: Numbers) -> Runs:
        """The runs of rows, and the conditions under which their leakage flows are solved."""
        calibration_of = np.full(len(numbers), NO_ROW, dtype=np.intp)
        needed = np.flatnonzero(self._needs_solution(numbers))
        choices, made = self._table.choices, self._table.made
        kept = [name for name in choices if name.partition(".")[0] not in OBSERVATION]
        conditions = self._conditions(numbers[needed])[:, [self._column[name] for name in kept]]
        first, calibration_of[needed] = _distinct(conditions)
        calibrations = ParameterTable(
            self._nominal.with_defaults(OBSERVATION),
            {name: choices[name] for name in kept},
            conditions[first],
            made=made,
        )
        choice = self._experiment.indicator_choice
        return Runs(self._nominal, choices, numbers, calibrations, calibration_of, choice, made=made)

    def swept_rows(self) -> Numbers:
        """The runs at all points, each once."""
        numbers = np.zeros((self._points.n_point, len(self._column)), dtype=np.int32)
        for name, column in self._points.columns.items():
            own = self._numbers[name]
            # A point that does not set the parameter has index −1, and its nominal value the number 0.
            numbers[:, self._column[name]] = np.array([*map(own.__getitem__, column.values), 0])[column.index]
        is_set = [
            self._points.columns[name].index != NOMINAL
            if name in self._points.columns
            else np.zeros(len(numbers), dtype=bool)
            for name in INTERNAL_LEAKAGE_FORMS
        ]
        for name, is_own, is_other in zip(INTERNAL_LEAKAGE_FORMS, is_set, is_set[::-1], strict=True):
            # A point that sets K_i cancels the flow of the file, and the other way round.
            numbers[is_other & ~is_own, self._column[name]] = self._numbers[name][None]
        self._require_possible(numbers)
        numbers = self._plainly_sealed(numbers)
        return numbers[_distinct(numbers)[0]]

    def with_baselines(self, rows: Numbers) -> tuple[Numbers, NDArray[np.intp], NDArray[np.intp]]:
        """Rows and the baselines that they lack, and where the fixed and matched baseline of each lies."""
        leakage = {name: value for name, value in self._baseline.items() if name.startswith("leakage.")}
        healthy = [self._plainly_sealed(self._changed(rows, new)) for new in (self._baseline, leakage)]
        (first_fixed, of_fixed), (first_matched, of_matched) = map(_distinct, healthy)
        # In the order of the runs that need them first, each fixed baseline before the matched one.
        by_turns = np.argsort(np.concatenate([2 * first_fixed, 2 * first_matched + 1]))
        baselines = np.concatenate([healthy[0][first_fixed], healthy[1][first_matched]])
        together = np.concatenate([rows, baselines[by_turns]])
        first, index = _distinct(together)
        if len(first) > len(rows):
            # A baseline that was added needs baselines, too; those of baselines are known, so this ends.
            return self.with_baselines(together[first])
        rows_of = np.empty(len(by_turns), dtype=np.intp)
        rows_of[by_turns] = index[len(rows) :]
        n_fixed = len(first_fixed)
        return rows, rows_of[:n_fixed][of_fixed], rows_of[n_fixed:][of_matched]

    def _changed(self, numbers: Numbers, changes: Mapping[str, Any]) -> Numbers:
        """Rows with dotted values replaced; either form of the internal leakage replaces the other."""
        forms = dict.fromkeys(INTERNAL_LEAKAGE_FORMS) if changes.keys() & set(INTERNAL_LEAKAGE_FORMS) else {}
        changed = numbers.copy()
        for name, value in (forms | dict(changes)).items():
            changed[:, self._column[name]] = self._numbers[name][value]
        self._require_possible(changed, changes)
        return changed

    def _plainly_sealed(self, numbers: Numbers) -> Numbers:
        """Rows with one form of "no leakage": K_i = 0."""
        sealed = ~self._needs_solution(numbers) & self._has(numbers, "leakage.internal_coefficient", None)
        plain = numbers.copy()
        for name, value in self._sealed.items():
            plain[sealed, self._column[name]] = self._numbers[name][value]
        return plain

    def _needs_solution(self, numbers: Numbers) -> NDArray[np.bool_]:
        flow = "leakage.internal_flow"
        return ~(self._has(numbers, flow, None) | self._has(numbers, flow, 0.0))

    def _has(self, numbers: Numbers, name: str, value: Any) -> NDArray[np.bool_]:
        is_same: NDArray[np.bool_] = numbers[:, self._column[name]] == self._numbers[name][value]
        return is_same

    def _conditions(self, numbers: Numbers) -> Numbers:
        """The conditions under which the leakage flows of rows are solved."""
        conditions = numbers.copy()
        if self._experiment.calibration.at == "nominal":
            kept = {*self._experiment.ensemble.names, *INTERNAL_LEAKAGE_FORMS}
            conditions[:, [column for name, column in self._column.items() if name not in kept]] = 0
        baseline = self._baseline.items()
        return self._changed(
            conditions, {name: value for name, value in baseline if name not in INTERNAL_LEAKAGE_FORMS}
        )

    def _require_possible(self, numbers: Numbers, changes: Mapping[str, Any] | None = None) -> None:
        """Check the changed sections of rows, alone and together; without `changes`, rows are the points."""
        changed = self._points.columns if changes is None else changes
        table, sections = replace(self._table, numbers=numbers), {name.partition(".")[0] for name in changed}
        alone = [(name,) for name in RunRequest.model_fields if name in sections]
        for fitting in (*alone, *RunRequest.fits):
            if sections.isdisjoint(fitting):
                continue
            for row in table.combinations(*fitting)[0].tolist():
                try:
                    made = [table.section(name, row) for name in fitting]  # which checks each alone
                    if fitting in RunRequest.fits:
                        RunRequest.fits[fitting](*made)
                except ValueError as error:
                    values = self._points.values(row) if changes is None else changes
                    own = {name: value for name, value in values.items() if name.partition(".")[0] in fitting}
                    raise self._impossible(error, own, row if changes is None else None) from None

    def _impossible(self, error: ValueError, values: Mapping[str, Any], point: int | None) -> ConfigError:
        """The error of a point, or of changes of many, with the last values [SI] that do not fit."""
        study, where = self._study, ""
        if study is not None and point is not None:
            where = f"in the population {study.populations[study.of_run[point]].title!r}, "
        named = shown_values(dict([*values.items()][-4:]))
        message = f"{where}at {named}: {first_reason(error)}"
        return ConfigError([Issue(message, "sweep" if study is None else "study")])


def _distinct(numbers: Numbers) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where each of the distinct rows appears first, and which of them each row is."""
    return distinct_rows([*numbers.T], len(numbers))


def _numbered(name: str, values: Iterable[Any]) -> dict[Any, int]:
    """The number of each value of a parameter; files with the same contents have the same."""
    number_of: dict[Any, int] = {}
    same = digest if name == "input.file" else str
    return {
        value: number_of.setdefault(same(value) if isinstance(value, str) else value, len(number_of))
        for value in values
    }


def _first_values(numbers: Mapping[Any, int]) -> list[Any]:
    first: dict[int, Any] = {}
    for value, number in numbers.items():
        first.setdefault(number, value)
    return list(first.values())
