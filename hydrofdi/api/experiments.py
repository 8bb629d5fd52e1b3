"""Experiments by a file, a mapping, and keywords."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from hydrofdi.api.arguments import path_of
from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.errors import ConfigError

Experiment = str | PathLike[str] | Mapping[str, Any] | ExperimentConfig
"""A YAML file, what would stand in one, or an experiment that is loaded."""


def experiment_of(experiment: Experiment | None, settings: Mapping[str, Any]) -> ExperimentConfig:
    """The experiment that a file or a mapping and keywords describe.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    if isinstance(experiment, ExperimentConfig):
        if settings:
            raise ConfigError("the experiment is already loaded; pass the settings to load_experiment")
        return experiment
    if experiment is None or isinstance(experiment, Mapping):
        return load_experiment(experiment, settings)
    return load_experiment(path_of(experiment), settings)


def stated_experiment(experiment: Experiment, settings: Mapping[str, Any]) -> ExperimentConfig:
    """The experiment of a sweep, which is required.

    Raises
    ------
    ConfigError
        With every mistake, or no experiment is given.
    """
    return experiment_of({} if experiment is None else experiment, settings)


def experiment_with(file: str | PathLike[str] | None, settings: Sequence[str]) -> ExperimentConfig:
    """The experiment in a file, or the nominal one, with settings such as ``fluid.bulk_modulus=689 MPa``.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    return load_experiment(None if file is None else path_of(file), settings)
