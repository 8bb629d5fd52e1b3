"""Values that a shift or a confusion gives parameters: absolute, or relative to the nominal value."""

from __future__ import annotations

from typing import Any

from hydrofdi.config.request import parameter_names
from hydrofdi.config.sweeps.values import nominal_value, parameter_value
from hydrofdi.settings.yaml_source import Path, Source
from hydrofdi.units import parse_quantity


def changed_value(source: Source, path: Path, name: str, value: Any) -> Any:
    """A value of a parameter in SI; ``+25 %`` and ``−25 %`` are relative to its nominal value.

    What cannot be a value stays as it is, and becomes a mistake of the source.
    """
    if not _is_relative(value) or name not in parameter_names():
        return parameter_value(source, path, name, value)
    nominal = nominal_value(source, name)
    if isinstance(nominal, bool) or not isinstance(nominal, float) or nominal == 0.0:
        what = "0" if nominal == 0.0 else "no number"
        message = f"{value} is relative to the nominal value, and {name} has {what}; state the value itself"
        source.mistakes.append(source.mistake(path, message))
        return value
    try:
        change = parse_quantity(value.replace("−", "-"), "1")
    except ValueError as error:
        source.mistakes.append(source.mistake(path, str(error)))
        return value
    if change == 0.0:
        source.mistakes.append(source.mistake(path, f"{value} changes nothing"))
        return value
    return parameter_value(source, path, name, nominal * (1.0 + change))


def _is_relative(value: Any) -> bool:
    return isinstance(value, str) and value.strip()[:1] in ("+", "-", "−") and value.rstrip().endswith("%")
