"""An experiment → its runs as rows of section numbers, their calibrations and their baselines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig
from hydrofdi.config.request import OBSERVATION, RunRequest, replace_fields
from hydrofdi.config.run_table.roles import StudyTable, populations, study_points, study_table
from hydrofdi.config.run_table.runs import NONE, Frame, Runs, SectionPool
from hydrofdi.config.sections.machine import LeakageConfig
from hydrofdi.config.shown_values import shown_values
from hydrofdi.config.study import StudyConfig
from hydrofdi.config.sweeps.points import Column, Points, count_points, multiplied, sweep_points
from hydrofdi.config.sweeps.sweep import distinct_rows
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import counted, first_reason
from hydrofdi.settings.quantities import Section

MOST_RUNS = 1_000_000
"""Points that one sweep may have."""


NO_RUN = -1
"""Stands for a run that does not exist."""


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
    if experiment.study is not None:
        return _expand_study(experiment, experiment.study)
    _require_countable(count_points(experiment.ensemble) * count_points(experiment.sweep))
    scenarios, swept = (_block_points(experiment, section) for section in ("ensemble", "sweep"))
    points = multiplied(scenarios, swept)
    expansion = Expansion(experiment, points)
    rows = expansion.swept_rows()
    n_swept = rows.shape[1]
    rows, fixed, matched = expansion.with_baselines(rows)
    return RunTable(expansion.runs(rows), _axes(points), n_swept, fixed, matched)


def _expand_study(experiment: ExperimentConfig, study: StudyConfig) -> RunTable:
    """The runs of all populations, in each design."""
    n_record = sum(each.count for each in populations(study))
    _require_countable(count_points(experiment.sweep) * n_record, "study")
    points = multiplied(_block_points(experiment, "sweep"), study_points(study))
    table = study_roles(experiment)
    expansion = Expansion(experiment, points, table)
    rows = expansion.swept_rows()
    n_run = rows.shape[1]
    if n_run < points.n_point:
        message = f"draws {counted(points.n_point - n_run, 'record')} twice; let more of them vary"
        raise ConfigError([Issue(message, "study.population")])
    none = np.full(n_run, NO_RUN)
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
    axes = {}
    for name, column in points.columns.items():
        first, _ = distinct_rows([column.index], points.n_point)
        numbers = column.index[first].tolist()
        axes[name] = tuple(dict.fromkeys(column.values[number] for number in numbers if number >= 0))
    return axes


Numbers = NDArray[np.int32]
"""Numbers of sections, shape (n_run, n_pool)."""

Rows = NDArray[np.int32]
"""Runs as three kinds of `Numbers`, shape (3, n_run, n_pool): of the run; of the conditions under which its
leakage flow is solved, or ``NONE``; and of the actuator that these are made from if it is the nominal one."""


class Expansion:
    """Points turned into runs, section by section: each different section is made and checked once."""

    def __init__(self, experiment: ExperimentConfig, points: Points, study: StudyTable | None = None) -> None:
        self._points = points
        self._study = study
        self._nominal = experiment.nominal_parameters
        self._baseline = experiment.baseline
        self._scenarios = set(experiment.ensemble.names)
        self._is_solved_nominally = experiment.calibration.at == "nominal"
        self._leakage = {name: value for name, value in self._baseline.items() if name.startswith("leakage.")}
        self._conditions = {
            name: value for name, value in self._baseline.items() if name not in INTERNAL_LEAKAGE_FORMS
        }
        self._choice = experiment.indicator_choice
        varied = {name.partition(".")[0] for name in (*points.columns, *self._baseline)}
        self._names = tuple(name for name in RunRequest.model_fields if name in varied)
        self._pools = {name: SectionPool(getattr(self._nominal, name)) for name in self._names}

    def runs(self, rows: Rows) -> Runs:
        """The runs of rows."""
        plain = self._nominal.with_defaults(OBSERVATION)
        return Runs(
            Frame(self._nominal, self._pools, rows[0]),
            Frame(plain, self._pools, rows[1]),
            self._choice,
        )

    def swept_rows(self) -> Rows:
        """The runs at all points, each once."""
        numbers = self._at_points(self._points.columns)
        self._require_fit(numbers, self._points.columns)
        sources = numbers
        if self._is_solved_nominally:
            columns = self._points.columns.items()
            sources = self._at_points({name: column for name, column in columns if name in self._scenarios})
        return _distinct(self._solved(self._plainly_sealed(numbers), sources))[0]

    def with_baselines(self, rows: Rows) -> tuple[Rows, NDArray[np.intp], NDArray[np.intp]]:
        """Rows and the baselines that they lack, and where the fixed and matched baseline of each lies."""
        (fixed, first_fixed, of_fixed), (matched, first_matched, of_matched) = (
            _distinct(self._healthy(rows, changes)) for changes in (self._baseline, self._leakage)
        )
        by_turns = np.argsort(np.concatenate([2 * first_fixed, 2 * first_matched + 1]))
        n_row, n_fixed = rows.shape[1], len(first_fixed)
        together, _, places = _distinct(_joined(rows, _joined(fixed, matched)[:, by_turns]))
        if together.shape[1] > n_row:
            return self.with_baselines(together)
        found = np.empty(len(by_turns), dtype=np.intp)
        found[by_turns] = places[n_row:]
        return rows, found[:n_fixed][of_fixed], found[n_fixed:][of_matched]

    def _at_points(self, columns: Mapping[str, Column]) -> Numbers:
        """Numbers of the sections at all points where some parameters vary."""
        numbers = np.zeros((self._points.n_point, len(self._names)), dtype=np.int32)
        for place, section in enumerate(self._names):
            names = [name for name in columns if name.partition(".")[0] == section]
            if names:
                first, inverse = distinct_rows([columns[name].index for name in names], len(numbers))
                made = [self._section_at(section, names, point) for point in first.tolist()]
                numbers[:, place] = np.array(made, dtype=np.int32)[inverse]
        return numbers

    def _section_at(self, section: str, names: Sequence[str], point: int) -> int:
        values = self._points.values(point, names)
        pool, fields = self._pools[section], _fields(values, section)
        try:
            return pool.number(replace_fields(pool.sections[0], fields)) if fields else 0
        except ValueError as error:
            raise self._impossible(error, values, point) from None

    def _impossible(self, error: ValueError, values: Mapping[str, Any], point: int | None) -> ConfigError:
        """The error of a point, or of changes of many, with the last values [SI] that do not fit."""
        study, where = self._study, ""
        if study is not None and point is not None:
            where = f"in the population {study.populations[study.of_run[point]].title!r}, "
        named = shown_values(dict([*values.items()][-4:]))
        message = f"{where}at {named}: {first_reason(error)}"
        return ConfigError([Issue(message, "sweep" if study is None else "study")])

    def _require_fit(
        self,
        numbers: Numbers,
        changed: Iterable[str],
        values: Callable[[int], Mapping[str, Any]] | None = None,
    ) -> None:
        """Check that changed sections of rows fit each other; without `values`, rows are the points."""
        sections = {name.partition(".")[0] for name in changed}
        frame = Frame(self._nominal, self._pools, numbers)
        for fitting in RunRequest.fits:
            if sections.isdisjoint(fitting):
                continue
            first, _ = distinct_rows([frame.column(name) for name in fitting], len(numbers))
            for row in first.tolist():
                try:
                    frame.request(row).require_fit(fitting)
                except ValueError as error:
                    changes = self._points.values(row) if values is None else values(row)
                    own = {
                        name: value for name, value in changes.items() if name.partition(".")[0] in fitting
                    }
                    raise self._impossible(error, own, row if values is None else None) from None

    def _changed(self, numbers: Numbers, changes: Mapping[str, Any]) -> Numbers:
        """Rows with dotted values replaced."""
        changed = numbers.copy()
        for place, section in enumerate(self._names):
            if fields := _fields(changes, section):
                pool, change = self._pools[section], partial(replace_fields, fields=fields)
                if self._varied(section) <= {name for name, _ in fields}:
                    changed[:, place] = pool.number(change(pool.sections[0]))
                else:
                    changed[:, place] = _mapped(pool, numbers[:, place], change)
        self._require_fit(changed, changes, lambda _: changes)
        return changed

    def _varied(self, section: str) -> set[str]:
        """The fields in which the contents of a section differ."""
        forms = INTERNAL_LEAKAGE_FORMS if section == "leakage" else ()
        names = (*self._points.columns, *self._baseline, *forms)
        return {field for owner, _, field in (name.partition(".") for name in names) if owner == section}

    def _plainly_sealed(self, numbers: Numbers) -> Numbers:
        """Rows with one form of "no leakage": K_i = 0."""
        place, sealed = self._names.index("leakage"), numbers.copy()
        sealed[:, place] = _mapped(self._pools["leakage"], numbers[:, place], _plain_sealed_state)
        return sealed

    def _healthy(self, rows: Rows, changes: Mapping[str, Any]) -> Rows:
        numbers = self._plainly_sealed(self._changed(rows[0], changes))
        return self._solved(numbers, rows[2])

    def _solved(self, numbers: Numbers, sources: Numbers) -> Rows:
        """Rows with the conditions under which their leakage flows are solved."""
        place, pool = self._names.index("leakage"), self._pools["leakage"]
        solved = [isinstance(each, LeakageConfig) and each.needs_calibration for each in pool.sections]
        needed = np.array(solved)[numbers[:, place]]
        calibrations = np.full_like(numbers, NONE)
        if needed.any():
            conditions = numbers[needed]
            if self._is_solved_nominally:
                conditions = self._with_flows_of(conditions, sources[needed])
            conditions = self._changed(conditions, self._conditions)
            for section in set(self._names) & OBSERVATION.keys():
                plain = self._pools[section].number(OBSERVATION[section]())
                conditions[:, self._names.index(section)] = plain
            calibrations[needed] = conditions
        return np.stack([numbers, calibrations, sources])

    def _with_flows_of(self, numbers: Numbers, sources: Numbers) -> Numbers:
        """Sources with the leakage flows of runs."""
        place, pool = self._names.index("leakage"), self._pools["leakage"]
        first, inverse = distinct_rows([sources[:, place], numbers[:, place]], len(numbers))
        made = []
        for row in first.tolist():
            flow: Any = pool.sections[numbers[row, place]]
            fields = (("internal_flow", flow.internal_flow),)
            made.append(pool.number(replace_fields(pool.sections[sources[row, place]], fields)))
        asked = sources.copy()
        asked[:, place] = np.array(made, dtype=np.int32)[inverse]
        return asked


def _distinct(rows: Rows) -> tuple[Rows, NDArray[np.intp], NDArray[np.intp]]:
    """The distinct runs in order of appearance, where each appears first, and which of them each row is."""
    first, inverse = distinct_rows([*rows[0].T, *rows[1].T], rows.shape[1])
    return rows[:, first], first, inverse


def _joined(*parts: Rows) -> Rows:
    return np.concatenate(parts, axis=1)


def _mapped(pool: SectionPool, numbers: Numbers, change: Callable[[Section], Section]) -> Numbers:
    """Numbers of sections after a change, which each different section undergoes once."""
    different, inverse = np.unique(numbers, return_inverse=True)
    changed = [pool.number(change(pool.sections[number])) for number in different.tolist()]
    return np.array(changed, dtype=np.int32)[inverse]


def _fields(values: Mapping[str, Any], section: str) -> tuple[tuple[str, Any], ...]:
    """What dotted values say of a section."""
    split = ((*name.split("."), value) for name, value in values.items())
    return tuple((field, value) for owner, field, value in split if owner == section)


def _plain_sealed_state(leakage: Section) -> Section:
    assert isinstance(leakage, LeakageConfig)
    is_stated = leakage.needs_calibration or leakage.internal_coefficient is not None
    return leakage if is_stated else _sealed(leakage)


@lru_cache(maxsize=1024)
def _sealed(leakage: LeakageConfig) -> LeakageConfig:
    names = ("external_coefficient", "external_coefficient_1", "external_coefficient_2")
    return LeakageConfig(internal_coefficient=0.0, **{name: getattr(leakage, name) for name in names})
