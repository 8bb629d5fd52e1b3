"""An experiment → the runs that it asks for, each with the healthy runs to compare it with."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig
from hydrofdi.config.leakage import LeakageConfig
from hydrofdi.config.mistakes import describe_error
from hydrofdi.config.parameters import RunParameters
from hydrofdi.config.quantities import Section
from hydrofdi.errors import ConfigError, Mistake


@dataclass(frozen=True)
class RunSpec:
    """One resolved run.

    Attributes
    ----------
    parameters : RunParameters
        All that is simulated.
    calibration : RunParameters or None
        The conditions under which the internal leakage flow is solved for K_i; None where K_i is given.
    """

    parameters: RunParameters
    calibration: RunParameters | None = None

    @property
    def request(self) -> str:
        """The request as canonical JSON in SI; equal requests are equal texts."""
        calibration = None if self.calibration is None else canonical_json(self.calibration)
        return f'{{"calibration":{calibration or "null"},"parameters":{canonical_json(self.parameters)}}}'


@dataclass(frozen=True)
class RunTable:
    """The runs of an experiment in their order.

    Attributes
    ----------
    runs : tuple of RunSpec, length n_run
        The swept runs, the last axis varying fastest, then the healthy runs that the sweep itself lacks.
    axes : dict
        Dotted parameter → its values in SI.
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

    Raises
    ------
    ConfigError
        A combination of swept values is impossible.
    """
    nominal, axes = experiment.nominal, experiment.sweep.grid
    runs = [
        resolve_run(_at_point(nominal, dict(zip(axes, values, strict=True))), experiment)
        for values in product(*axes.values())
    ]
    n_swept = len(runs)
    index = {run: position for position, run in reversed(list(enumerate(runs)))}
    leakage = {name: value for name, value in experiment.baseline.items() if name.startswith("leakage.")}

    def baseline_index(run: RunSpec, changes: Mapping[str, Any]) -> int:
        baseline = resolve_run(_at_point(run.parameters, changes), experiment)
        if baseline not in index:
            index[baseline] = len(runs)
            runs.append(baseline)
        return index[baseline]

    swept = tuple(runs)
    fixed = [baseline_index(run, experiment.baseline) for run in swept]
    matched = [baseline_index(run, leakage) for run in swept]
    for added in runs[n_swept:]:
        fixed.append(baseline_index(added, experiment.baseline))
        matched.append(baseline_index(added, leakage))
    return RunTable(
        tuple(runs),
        {name: tuple(values) for name, values in axes.items()},
        n_swept,
        tuple(fixed),
        tuple(matched),
    )


def resolve_run(parameters: RunParameters, experiment: ExperimentConfig) -> RunSpec:
    """A run with the conditions under which its leakage flow, if it is given as such, is solved for K_i."""
    parameters = _with_plain_sealed_state(parameters)
    if not parameters.leakage.needs_calibration:
        return RunSpec(parameters)
    conditions = {
        name: value for name, value in experiment.baseline.items() if name not in INTERNAL_LEAKAGE_FORMS
    }
    return RunSpec(parameters, parameters.with_values(conditions))


def canonical_json(parameters: RunParameters) -> str:
    """Parameters as JSON with sorted keys and floats in their shortest exact form."""
    sections = (f'"{name}":{_section_json(getattr(parameters, name))}' for name in _SECTIONS)
    return "{" + ",".join(sections) + "}"


_SECTIONS = sorted(RunParameters.model_fields)


@lru_cache(maxsize=8192)
def _section_json(section: Section) -> str:
    return json.dumps(section.model_dump(), sort_keys=True, separators=(",", ":"))


def _with_plain_sealed_state(parameters: RunParameters) -> RunParameters:
    """Give "no leakage" one form: K_i = 0."""
    leakage = parameters.leakage
    if leakage.needs_calibration or leakage.internal_coefficient is not None:
        return parameters
    sealed = _sealed(leakage)
    sections = {name: getattr(parameters, name) for name in RunParameters.model_fields}
    return RunParameters.model_construct(**(sections | {"leakage": sealed}))


@lru_cache(maxsize=1024)
def _sealed(leakage: LeakageConfig) -> LeakageConfig:
    return LeakageConfig(internal_coefficient=0.0, external_coefficient=leakage.external_coefficient)


def _at_point(parameters: RunParameters, values: Mapping[str, Any]) -> RunParameters:
    try:
        return parameters.with_values(values)
    except ValueError as error:
        point = ", ".join(f"{name} = {value:g}" if isinstance(value, float) else f"{name} = {value}"
                          for name, value in values.items())  # fmt: skip
        reason = describe_error(error.errors()[0]) if isinstance(error, ValidationError) else error
        raise ConfigError([Mistake(f"at {point}: {reason}", "sweep")]) from None
