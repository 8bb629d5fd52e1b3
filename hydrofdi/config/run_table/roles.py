"""Who is who among the runs of a study: it follows from the experiment alone, whatever was drawn."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.study import PopulationConfig, StudyConfig
from hydrofdi.config.sweeps.points import Column, Points, drawn, one_after_the_other
from hydrofdi.config.sweeps.sweep import correlated, unit_cube
from hydrofdi.evaluation.scores import NOTHING, Kind, Population
from hydrofdi.settings.readable import K_I_UNIT, shown_quantity
from hydrofdi.units import convert

_PATH = "study.population"


def study_points(study: StudyConfig) -> Points:
    """The points of a study, population by population."""
    return one_after_the_other([_points(study.population, each) for each in populations(study)])


def _points(config: PopulationConfig, each: Drawn) -> Points:
    own = correlated(_cube(config, each), list(config.over), config.correlation)
    columns = {
        name: _drawn(name, law, own[:, axis], f"{_PATH}.over.{name}")
        for axis, (name, law) in enumerate(config.over.items())
        if each.varied is None or name in each.varied
    }
    others = f"study.{each.population.kind.value}s.{each.population.name}"
    for path, stated in ((f"{_PATH}.per_record", config.per_record), (others, each.settings)):
        for name, value in stated.items():
            if isinstance(value, Mapping):
                unit = _unit(config, each.identity, name, each.count)
                columns[name] = _drawn(name, dict(value), unit, f"{path}.{name}")
            else:
                columns[name] = Column([value], np.zeros(each.count, dtype=np.int32))
    return Points(each.count, columns)


def _drawn(name: str, law: dict[Any, list[Any]], unit: NDArray[np.float64], path: str) -> Column:
    values = drawn(name, law, unit, path)
    places = {value: place for place, value in enumerate(dict.fromkeys(values))}
    return Column(list(places), np.array([places[value] for value in values], dtype=np.int32))


def _cube(config: PopulationConfig, each: Drawn) -> NDArray[np.float64]:
    """Points in the unit cube of what is drawn, shape (count, number of parameters)."""
    if config.method == "random":
        axes = [_unit(config, each.actuators, name, each.count) for name in config.over]
        return np.stack(axes, axis=1) if axes else np.empty((each.count, 0))
    return unit_cube(config.method, each.count, len(config.over), _seed_sequence(config.seed, each.actuators))


def _unit(config: PopulationConfig, population: str, name: str, count: int) -> NDArray[np.float64]:
    return np.random.default_rng(_seed_sequence(config.seed, population, name)).random(count)


def _seed_sequence(seed: int, *names: str) -> np.random.SeedSequence:
    digest = hashlib.sha256("\n".join(names).encode()).digest()
    return np.random.SeedSequence(seed, spawn_key=tuple(np.frombuffer(digest, dtype="<u4").tolist()))


@dataclass(frozen=True)
class Drawn:
    """A population with its records.

    Attributes
    ----------
    actuators : str
        Which stream its actuators are drawn from; populations of one stream have the same ones.
    settings : mapping
        Dotted parameter → value in SI, or distribution, in place of what is drawn in healthy actuators.
    varied : tuple of str or None
        What differs from actuator to actuator; None for all of ``population.over``.
    """

    population: Population
    count: int
    actuators: str
    settings: Mapping[str, Any]
    varied: tuple[str, ...] | None = None

    @property
    def identity(self) -> str:
        """Name of the stream that all else is drawn from."""
        return _stream(self.population)


@dataclass(frozen=True, eq=False)
class StudyTable:
    """The roles of the runs of a study: population, design (parameter → value in SI) and actuator.

    Runs of one design with the same name in `actuators` are of the same actuator; None if each has its own.
    """

    populations: tuple[Population, ...]
    of_run: NDArray[np.intp]
    designs: tuple[dict[str, Any], ...]
    design_of_run: NDArray[np.intp]
    actuators: tuple[str, ...] | None


def populations(study: StudyConfig) -> tuple[Drawn, ...]:
    """All populations of a study in the order of its runs."""
    healthy = [
        _healthy(_sealed(is_fit), count)
        for is_fit, count in ((True, study.healthy.fit), (False, study.healthy.test))
    ]
    judged = [*healthy, *_faulty(study), *_others(study)]
    if study.pairing == "common":
        judged = [
            replace(each, actuators=_stream(_sealed(each.population.is_fit)))
            for each in (*_before(judged), *judged)
        ]
    return (*judged, *_alone(study))


def study_table(study: StudyConfig, designs: Sequence[dict[str, Any]]) -> StudyTable:
    """The roles of the runs of a study: all populations of the first design, then those of the next."""
    drawn = populations(study)
    counts = [each.count for each in drawn]
    of_run = np.repeat(np.arange(len(drawn)), counts)
    actuators = [f"{each.actuators} {place}" for each in drawn for place in range(each.count)]
    return StudyTable(
        tuple(each.population for each in drawn),
        np.tile(of_run, len(designs)),
        tuple(designs),
        np.repeat(np.arange(len(designs)), len(of_run)),
        None if study.pairing == "independent" else tuple(actuators) * len(designs),
    )


def _sealed(is_fit: bool) -> Population:
    return Population("healthy", Kind.HEALTHY, is_fit)


def _before(judged: Sequence[Drawn]) -> list[Drawn]:
    """A healthy record of every actuator that is judged, taken before."""
    counts = [
        (is_fit, max(each.count for each in judged if each.population.is_fit is is_fit))
        for is_fit in (True, False)
    ]
    return [_healthy(Population("before", Kind.BEFORE, is_fit), count) for is_fit, count in counts]


def _healthy(population: Population, count: int, settings: Mapping[str, Any] | None = None) -> Drawn:
    sealed = {"leakage.internal_coefficient": 0.0}
    return Drawn(population, count, _stream(population), sealed | dict(settings or {}))


def _faulty(study: StudyConfig) -> list[Drawn]:
    faults = study.faults
    if faults is None:
        return []
    drawn = []
    for level in faults.levels:
        for is_fit, count in ((True, faults.fit), (False, faults.each)):
            population = Population(_leak(faults.parameter, level), Kind.FAULT, is_fit, level)
            if count:
                drawn.append(Drawn(population, count, _stream(population), {faults.parameter: level}))
    return drawn


def _others(study: StudyConfig) -> list[Drawn]:
    healthy = study.healthy
    return [
        _healthy(Population(name, kind), count or healthy.test, settings)
        for kind, named, count in (
            (Kind.SHIFT, study.shifts, healthy.shift),
            (Kind.CONFUSION, study.confusions, healthy.confusion),
        )
        for name, settings in named.items()
    ]


def _alone(study: StudyConfig) -> list[Drawn]:
    count = study.sensitivity.alone
    varied: dict[str, tuple[str, ...]] = {name: (name,) for name in study.population.over} | {NOTHING: ()}
    drawn = [(_healthy(Population(name, Kind.ALONE), count), own) for name, own in varied.items()]
    return [replace(each, varied=own) for each, own in drawn] if count else []


def _leak(parameter: str, level: float) -> str:
    if parameter == "leakage.internal_flow":
        return f"{convert(level, 'L/min'):.4g} L/min"
    return f"K_i {shown_quantity(level, K_I_UNIT)}"


def _stream(population: Population) -> str:
    kind, part = population.kind.value, "fit" if population.is_fit else "test"
    return f"{kind} {population.severity!r} {population.name} {part}"
