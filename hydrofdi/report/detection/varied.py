"""What varies in the populations of a study, in readable units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hydrofdi.config.request import parameter_unit
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.units import convert

_READABLE = {
    "Pa": (("MPa", 1e6), ("kPa", 1e3)),
    "m^3/s": (("L/min", 0.0),),
    "m": (("m", 1.0), ("mm", 1e-4), ("µm", 0.0)),
    "m^3": (("cm^3", 0.0),),
}
"""SI unit → units that a person reads, and from which size on."""

_WRITTEN = {
    "uniform": "{} … {} {unit}",
    "integers": "{} … {} {unit}",
    "loguniform": "{} … {} {unit} (logarithmic)",
    "normal": "{} ± {} {unit} (normal)",
    "truncated_normal": "{} ± {} {unit} (normal), from {} to {} {unit}",
    "lognormal": "{} {unit}, factor {} (lognormal)",
    "triangular": "{} … {} … {} {unit} (triangular)",
}


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
    common = {name: described(name, value) for name, value in drawn.items() if not name.endswith("seed")}
    changes = {
        label: ", ".join(f"{name} {described(name, value)}" for name, value in own.items())
        for label, own in (*study.shifts.items(), *study.confusions.items())
    }
    return Varied(common, changes)


def described(name: str, value: Any) -> str:
    """A value of a parameter or its distribution, such as ``441 … 661 MPa``."""
    kind, arguments = next(iter(value.items())) if isinstance(value, dict) else ("", [value])
    n_own = 1 if kind == "lognormal" else len(arguments)
    shown, unit = _in_one_unit(name, arguments[:n_own])
    shown += map(_four_digits, arguments[n_own:])
    written = _WRITTEN.get(kind, "")
    if not written or len(shown) != written.count("{}"):
        written = f"{' or '.join(shown)} {{unit}}"
    return " ".join(written.format(*shown, unit=unit).split()).replace(" ,", ",")


def _in_one_unit(name: str, values: list[Any]) -> tuple[list[str], str]:
    """Values as text, in the unit that suits the largest of them."""
    own = parameter_unit(name) or ""
    numbers = [abs(value) for value in values if isinstance(value, int | float)]
    if len(numbers) < len(values) or not numbers:
        return [str(value) for value in values], ""
    unit = readable_unit(own, max(numbers))
    shown = [_four_digits(convert(value, unit) if unit != own else value) for value in values]
    return shown, "" if unit == "1" else unit.replace("*", "·")


def readable_unit(own: str, largest: float) -> str:
    """The unit that a person reads numbers up to `largest`, in SI, in; their own where there is none."""
    return next((unit for unit, least in _READABLE.get(own, ()) if largest >= least), own)


def _four_digits(value: float) -> str:
    return f"{float(f'{value:.4g}'):g}"
