"""Experiments by a file, a mapping, and keywords."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from hydrofdi.api.places import path_of
from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.config.request import parameter_names
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import nearest

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
    keys = dotted_keys(settings)
    if experiment is None or isinstance(experiment, Mapping):
        return load_experiment(experiment, keys)
    return load_experiment(path_of(experiment), keys)


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


def dotted_keys(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords as dotted keys: ``bulk_modulus`` and ``fluid__bulk_modulus`` are ``fluid.bulk_modulus``.

    Keys of an experiment file, such as ``sweep``, stay what they are.

    Raises
    ------
    ConfigError
        With every keyword that is unknown, or belongs to more than one section.
    """
    sections: dict[str, list[str]] = {}
    for dotted in parameter_names():
        section, _, name = dotted.partition(".")
        sections.setdefault(name, []).append(section)
    keys, mistakes = {}, []
    for keyword, value in settings.items():
        key = keyword.replace("__", ".")
        if "." in key or key in ExperimentConfig.model_fields:
            keys[key] = value
            continue
        match sections.get(key, []):
            case [section]:
                keys[f"{section}.{key}"] = value
            case []:
                known = [*sections, *ExperimentConfig.model_fields]
                keywords = [dotted.replace(".", "__") for dotted in parameter_names()]
                whole = [each for each in keywords if each.replace("__", "_") == key]
                hint = nearest(key, whole or known) if len(key) > 1 else ""
                mistakes.append(Issue(f"unknown key{hint}", key))
            case several:
                choice = ", ".join(f"{section}__{key}" for section in several)
                mistakes.append(Issue(f"is a key of several sections; write one of {choice}", key))
    if mistakes:
        raise ConfigError(mistakes)
    return keys
