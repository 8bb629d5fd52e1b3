"""An experiment → the runs that it asks for, each with the healthy runs to compare it with."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.csv_input import brief
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig
from hydrofdi.config.leakage import LeakageConfig
from hydrofdi.config.mistakes import describe_error
from hydrofdi.config.parameters import RunParameters, parameter_names, parameter_unit
from hydrofdi.config.points import Point, sweep_points
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.errors import ConfigError, Mistake


@dataclass(frozen=True, eq=False)
class RunSpec:
    """One resolved run.

    Attributes
    ----------
    parameters : RunParameters
        All that is simulated.
    calibration : RunParameters or None
        The conditions under which the internal leakage flow is solved for K_i, sensors left aside; None where
        K_i is given.
    """

    parameters: RunParameters
    calibration: RunParameters | None = None

    @property
    def request(self) -> str:
        """The request as canonical JSON in SI; equal requests are equal texts."""
        calibration = "null" if self.calibration is None else self.calibration.text()
        return f'{{"calibration":{calibration},"parameters":{self.parameters.text()}}}'

    @cached_property
    def request_digest(self) -> bytes:
        """SHA-256 of the request."""
        return hashlib.sha256(self.request.encode()).digest()


@dataclass(frozen=True)
class RunTable:
    """The runs of an experiment in their order.

    Attributes
    ----------
    runs : tuple of RunSpec, length n_run
        The swept runs in the order of the sweep, reading by reading, then the healthy runs
        that the sweep itself lacks.
    axes : dict
        Dotted parameter → its different values in SI, in order of appearance.
    n_swept : int
        How many of the runs belong to the sweep.
    fixed_baseline, matched_baseline : tuple of int, length n_run
        Index of the healthy run that a run is compared with: under the baseline's conditions, and under
        its own conditions with the baseline's leakage.
    """

    runs: tuple[RunSpec, ...]
    axes: dict[str, tuple[Any, ...]]
    n_swept: int
    fixed_baseline: tuple[int, ...]
    matched_baseline: tuple[int, ...]


def expand_runs(experiment: ExperimentConfig) -> RunTable:
    """The runs of the experiment's sweep and their baselines.

    Points that ask for the same run are one run.

    Raises
    ------
    ConfigError
        A combination of swept values is impossible, or the sweep is empty.
    """
    points = _points(experiment)
    expansion = _Expansion(experiment)
    for point in points:
        expansion.add(expansion.at(experiment.nominal_parameters, point))
    n_swept = len(expansion.runs)
    fixed, matched = expansion.baselines()
    axes = {
        name: tuple(dict.fromkeys(point[name] for point in points if name in point))
        for name in [*experiment.ensemble.names, *experiment.sweep.names]
    }
    return RunTable(tuple(expansion.runs), axes, n_swept, tuple(fixed), tuple(matched))


def _points(experiment: ExperimentConfig) -> list[Point]:
    readings = _block_points(experiment, "ensemble")
    swept = _block_points(experiment, "sweep")
    return [reading | point for reading in readings for point in swept]


def _block_points(experiment: ExperimentConfig, section: str) -> list[Point]:
    block: SweepConfig = getattr(experiment, section)
    if not block.names:
        return [{}]
    try:
        points = sweep_points(block, experiment.nominal_parameters.value)
    except ValidationError as error:
        raise ConfigError(
            [Mistake(f"sampled: {describe_error(error.errors()[0])}", f"{section}.sample")]
        ) from None
    if not points:
        raise ConfigError([Mistake("no point fulfils 'where'", section)])
    return points


class _Expansion:
    """Runs without repetition, in order of appearance."""

    def __init__(self, experiment: ExperimentConfig) -> None:
        self.runs: list[RunSpec] = []
        self._index: dict[bytes, int] = {}
        self._known_baselines: dict[tuple[str, ...], int] = {}
        self._baseline = experiment.baseline
        self._leakage = {name: value for name, value in self._baseline.items() if name.startswith("leakage.")}
        self._conditions = {
            name: value for name, value in self._baseline.items() if name not in INTERNAL_LEAKAGE_FORMS
        }

    def at(self, parameters: RunParameters, values: Mapping[str, Any]) -> RunSpec:
        """The run at a point."""
        moved = _with_plain_sealed_state(_with_values(parameters, values))
        if not moved.leakage.needs_calibration:
            return RunSpec(moved)
        return RunSpec(moved, _with_values(moved, self._conditions).with_ideal_sensors())

    def add(self, run: RunSpec) -> int:
        """Position of a run, added where it is new."""
        position = self._index.setdefault(run.request_digest, len(self.runs))
        if position == len(self.runs):
            self.runs.append(run)
        return position

    def baselines(self) -> tuple[list[int], list[int]]:
        """Positions of the fixed and the matched baseline of every run; adds the runs that lack."""
        fixed: list[int] = []
        matched: list[int] = []
        position = 0
        while position < len(self.runs):
            parameters = self.runs[position].parameters
            fixed.append(self._baseline_of(parameters, self._baseline))
            matched.append(self._baseline_of(parameters, self._leakage))
            position += 1
        return fixed, matched

    def _baseline_of(self, parameters: RunParameters, changes: Mapping[str, Any]) -> int:
        """Position of the run that changes make of another; the same sections make the same run."""
        changed, held = parameters.changed_sections(changes), parameters.__dict__
        sections = [changed.get(name) or held[name] for name in RunParameters.model_fields]
        key = tuple([section.stated_text for section in sections])
        if key not in self._known_baselines:
            self._known_baselines[key] = self.add(self.at(parameters, changes))
        return self._known_baselines[key]


def _with_values(parameters: RunParameters, values: Mapping[str, Any]) -> RunParameters:
    try:
        return parameters.with_values(values)
    except ValueError as error:
        reason = describe_error(error.errors()[0]) if isinstance(error, ValidationError) else error
        raise ConfigError([Mistake(f"at {told_values(values)}: {reason}", "sweep")]) from None


def told_values(values: Mapping[str, Any]) -> str:
    """Values of dotted parameters in SI, for people: ``valve.lap = 5e-05 m, fluid.law = free_air``."""
    return ", ".join(f"{name} = {told_value(name, value)}" for name, value in values.items())


def told_value(name: str, value: Any) -> str:
    """A value of a dotted parameter in SI, for people."""
    unit = parameter_unit(name)
    if not isinstance(value, float) or unit is None:
        return str(brief(value))
    return f"{value:g}" if unit == "1" else f"{value:g} {unit.replace('*', '·')}"


def varied_parameters(runs: Iterable[RunParameters]) -> list[str]:
    """The dotted parameters that are not the same in all runs."""
    first, *others = list(dict.fromkeys(runs))
    return [
        name for name in parameter_names() if any(other.value(name) != first.value(name) for other in others)
    ]


def _with_plain_sealed_state(parameters: RunParameters) -> RunParameters:
    """Give "no leakage" one form: K_i = 0."""
    leakage = parameters.leakage
    if leakage.needs_calibration or leakage.internal_coefficient is not None:
        return parameters
    return parameters.with_sections({"leakage": _sealed(leakage)})


@lru_cache(maxsize=1024)
def _sealed(leakage: LeakageConfig) -> LeakageConfig:
    return LeakageConfig(
        internal_coefficient=0.0,
        external_coefficient=leakage.external_coefficient,
        external_coefficient_1=leakage.external_coefficient_1,
        external_coefficient_2=leakage.external_coefficient_2,
    )
