"""Lines of a plan about a study: its populations, its designs, and what varies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hydrofdi.settings.counting import counted

_PURPOSES = {"alone": "to explain", "sobol": "to explain", "before": "to compare with"}
"""Kind of a population that is not tested → its purpose."""

_MOST_DESIGNS = 12
"""Most designs that have a line each."""


def study_lines(study: Mapping[str, Any]) -> list[str]:
    """The lines of a plan that belong to its study."""
    from hydrofdi.config.shown_values import shown_value

    designs = study["designs"]
    n_record, n_design = study["records"], len(designs)
    several = f": {n_record:,} in each of {n_design} designs" if n_design > 1 else ""
    lines = [
        f"runs         {counted(n_record * n_design, 'record')}{several}",
        *_population_lines(study["populations"]),
    ]
    if n_design > 1:
        lines += _titled("designs", [_settings(design) or "nominal" for design in designs[:_MOST_DESIGNS]])
        if n_design > _MOST_DESIGNS:
            lines.append(f"             and {n_design - _MOST_DESIGNS} more")
    width = max(map(len, study["varies"]), default=0)
    varied = [f"{name:<{width}}  {shown_value(name, own)}" for name, own in study["varies"].items()]
    lines += _titled("varies", varied or ["nothing"])
    return [*lines, f"  per record {', '.join(study['differs_per_record']) or 'nothing'}"]


def _population_lines(populations: list[dict[str, Any]]) -> Iterator[str]:
    """A line for each kind of population, and for each shift and confusion."""
    records: dict[tuple[str, str], list[str]] = {}
    sets = {(each["kind"], each["name"]): each["sets"] for each in populations}
    for each in populations:
        purpose = "to fit" if each["is_fit"] else _PURPOSES.get(each["kind"], "to test")
        own = records.setdefault((each["kind"], each["name"]), [])
        own.append(f"{each['records']:,} {purpose}")
    alike: dict[tuple[str, str, str], list[str]] = {}
    for (kind, name), counts in records.items():
        apart = f" ({_settings(sets[kind, name])})" if sets[kind, name] else ""
        alike.setdefault((kind, apart, ", ".join(counts)), []).append(name)
    for (kind, apart, count), names in alike.items():
        if names == [kind]:
            yield f"  {kind:<11}{count}"
        elif kind in ("alone", "sobol"):
            yield f"  {kind:<11}{len(names)} populations: {count} each"
        else:
            yield f"  {kind:<11}{_listed(names)}{apart}: {count}{' each' if len(names) > 1 else ''}"


def _listed(names: list[str]) -> str:
    """Names in a list; a unit that all of them have is written once."""
    unit = names[0].partition(" ")[2]
    if len(names) > 1 and unit and all(name.endswith(f" {unit}") for name in names):
        return f"{', '.join(name.removesuffix(f' {unit}') for name in names)} {unit}"
    return ", ".join(names)


def _settings(values: Mapping[str, Any]) -> str:
    from hydrofdi.config.shown_values import shown_value

    return ", ".join(f"{name} {shown_value(name, value)}" for name, value in values.items())


def _titled(title: str, texts: list[str]) -> list[str]:
    return [f"  {title if place == 0 else '':<11}{text}" for place, text in enumerate(texts)]
