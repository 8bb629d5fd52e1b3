"""The seeds that the runs of an experiment depend on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.plausibility import block_values, idle_draws
from hydrofdi.settings.quantities import Section

_OF_RECORDS = ("measurement.seed", "input.seed", "load.seed")


def seeds_of(experiment: ExperimentConfig) -> dict[str, int | list[int] | str]:
    """Dotted key of each seed that has an effect → its value, its values, or what it is drawn from.

    Those of records (sensor noise and jitter, pseudo-random inputs and loads) come first, then those of
    draws: samples, replicates, the population of a study, and scores.
    """
    idle = idle_draws(experiment, _OF_RECORDS)
    seeds: dict[str, int | list[int] | str] = {
        name: _values(name, experiment) for name in _OF_RECORDS if name not in idle
    }
    parts: dict[str, Section | None] = {"ensemble": experiment.ensemble, "sweep": experiment.sweep}
    parts["study"] = experiment.study
    if experiment.replicates.count:
        parts["replicates"] = experiment.replicates
    if experiment.study is not None:
        parts["detection"] = experiment.detection
    for name, part in parts.items():
        if part is not None:
            seeds |= dict(_nested(name, part.model_dump()))
    return seeds


def shown_seeds(seeds: Mapping[str, Any]) -> str:
    """Seeds in a line: ``measurement.seed 0 … 39, sweep.sample.seed 7``; ``none`` where there are none."""
    return ", ".join(f"{name} {_shown(value)}" for name, value in seeds.items()) or "none"


def _values(name: str, experiment: ExperimentConfig) -> int | list[int] | str:
    study = experiment.study
    if study is not None and name in study.population.per_record:
        return "drawn for each record from study.population.seed"
    blocks = (experiment.ensemble, experiment.sweep)
    own = {value for block in blocks for key, value in block_values(block) if key == name}
    values = sorted(own or {experiment.value(name)})
    if name == "measurement.seed":
        values += [experiment.value(name) + 1 + k for k in range(experiment.replicates.count)]
    return values[0] if len(values) == 1 else sorted(set(values))


def _nested(path: str, part: Any) -> Iterator[tuple[str, int]]:
    if isinstance(part, dict):
        if isinstance(part.get("seed"), int):
            yield f"{path}.seed", part["seed"]
        for name, value in part.items():
            yield from _nested(f"{path}.{name}", value)
    elif isinstance(part, list | tuple):
        for place, value in enumerate(part, 1):
            yield from _nested(f"{path}[{place}]", value)


def _shown(value: Any) -> str:
    if not isinstance(value, list):
        return str(value)
    first, last = value[0], value[-1]
    return f"{first} … {last}" if value == list(range(first, last + 1)) else ", ".join(map(str, value))
