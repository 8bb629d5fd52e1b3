"""The draws of a study → points: what each of its runs sets.

Each population is drawn from a stream of its own, and so is each parameter of independent draws: adding one
leaves the draws of the others alone. A larger population begins with the draws of a smaller one, except those
of a Latin hypercube.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.study.study import PopulationConfig, StudyConfig
from hydrofdi.config.study.table import Drawn, populations
from hydrofdi.config.sweeps.points import Column, Points, drawn, one_after_the_other
from hydrofdi.config.sweeps.sweep import correlated, unit_cube

_PATH = "study.population"


def study_points(study: StudyConfig) -> Points:
    """The points of a study, population by population.

    Raises
    ------
    ConfigError
        A drawn value is not one that its parameter can take.
    """
    return one_after_the_other([_points(study.population, each) for each in populations(study)])


def _points(config: PopulationConfig, each: Drawn) -> Points:
    columns = dict(_actuators(config, each)) | dict(_records(config, each)) | dict(_settings(config, each))
    return Points(each.count, columns)


def _actuators(config: PopulationConfig, each: Drawn) -> Iterator[tuple[str, Column]]:
    unit = correlated(_cube(config, each), list(config.over), config.correlation)
    for axis, (name, distribution) in enumerate(config.over.items()):
        if each.varied is None or name in each.varied:
            yield name, _column(drawn(name, distribution, unit[:, axis], f"{_PATH}.over.{name}"))


def _cube(config: PopulationConfig, each: Drawn) -> NDArray[np.float64]:
    """Points in the unit cube of what is drawn, shape (count, number of parameters)."""
    if config.method == "random":
        axes = [_unit(config, each.actuators, name, each.count) for name in config.over]
        return np.stack(axes, axis=1) if axes else np.empty((each.count, 0))
    return unit_cube(config.method, each.count, len(config.over), _stream(config.seed, each.actuators))


def _records(config: PopulationConfig, each: Drawn) -> Iterator[tuple[str, Column]]:
    for name, distribution in config.per_record.items():
        unit = _unit(config, each.identity, name, each.count)
        yield name, _column(drawn(name, distribution, unit, f"{_PATH}.per_record.{name}"))


def _settings(config: PopulationConfig, each: Drawn) -> Iterator[tuple[str, Column]]:
    path = f"study.{each.population.kind.value}s.{each.population.name}"
    for name, value in each.settings.items():
        if isinstance(value, Mapping):
            unit = _unit(config, each.identity, name, each.count)
            yield name, _column(drawn(name, dict(value), unit, f"{path}.{name}"))
        else:
            yield name, Column([value], np.zeros(each.count, dtype=np.int32))


def _column(values: list[Any]) -> Column:
    places = {value: place for place, value in enumerate(dict.fromkeys(values))}
    return Column(list(places), np.array([places[value] for value in values], dtype=np.int32))


def _unit(config: PopulationConfig, population: str, name: str, count: int) -> NDArray[np.float64]:
    return np.random.default_rng(_stream(config.seed, population, name)).random(count)


def _stream(seed: int, *names: str) -> np.random.SeedSequence:
    digest = hashlib.sha256("\n".join(names).encode()).digest()
    return np.random.SeedSequence(seed, spawn_key=tuple(np.frombuffer(digest, dtype="<u4").tolist()))
