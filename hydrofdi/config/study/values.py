"""The values that a study gives its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hydrofdi.config.study.study import StudyConfig
from hydrofdi.config.sweeps.distributions import argument_values


def study_values(study: StudyConfig) -> Iterator[tuple[str, Any]]:
    """The parameters that differ between records, each with every value or end of its distribution."""
    population, others = study.population, (*study.shifts.values(), *study.confusions.values())
    yield from ((name, level) for name, levels in _levels(study) for level in levels)
    for changes in (population.over, population.per_record, *others):
        for name, value in changes.items():
            stated = argument_values(dict(value)) if isinstance(value, Mapping) else [value]
            yield from ((name, each) for each in stated)


def _levels(study: StudyConfig) -> Iterator[tuple[str, list[Any]]]:
    if study.faults:
        yield from study.faults.over.items()
