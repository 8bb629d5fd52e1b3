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


def experiment_of(
    experiment: Experiment | None, settings: Mapping[str, Any] | Sequence[str]
) -> ExperimentConfig:
    """The experiment that a file or a mapping describes, the nominal one without either, with settings.

    These are keywords, or texts such as ``fluid.bulk_modulus=689 MPa``.

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
