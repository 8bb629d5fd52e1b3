"""What varies in the populations of a study, in readable units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hydrofdi.config.shown_values import shown_value
from hydrofdi.config.study.study import StudyConfig


@dataclass(frozen=True)
class Varied:
    """What differs between the records of a study.

    Attributes
    ----------
    common : mapping of str to str
        Parameter → its distribution in all populations.
    changes : mapping of str to str
        Shift or confusion → what is set or drawn otherwise there.
    """

    common: Mapping[str, str] = field(default_factory=dict)
    changes: Mapping[str, str] = field(default_factory=dict)


def varied(study: StudyConfig) -> Varied:
    """What a study varies."""
    drawn = {**study.population.over, **study.population.per_record}
    common = {name: shown_value(name, value) for name, value in drawn.items() if not name.endswith("seed")}
    changes = {
        label: ", ".join(f"{name} {shown_value(name, value)}" for name, value in own.items())
        for label, own in (*study.shifts.items(), *study.confusions.items())
    }
    return Varied(common, changes)
