"""What indicators take for granted about the plant behind measured records."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from hydrofdi.indicators import Indicator
from hydrofdi.indicators.plant_constants import constants_not_given, plant_constants
from hydrofdi.records import Channel, RecordSource
from hydrofdi.records.measured.held import HeldSource
from hydrofdi.records.measured.source import MeasuredSource
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.readable import shown_quantity


def assumed_constants(sources: Sequence[RecordSource], options: Section) -> tuple[str, ...]:
    """Constants of the plant that nobody gave; none if all records are simulated."""
    return constants_not_given(options) if any(map(_is_measured, sources)) else ()


def _is_measured(source: RecordSource) -> bool:
    if isinstance(source, HeldSource):
        return not source.is_simulated
    return isinstance(source, MeasuredSource)


def assumed_plants(
    sources: Sequence[RecordSource], indicators: Mapping[str, Indicator[Any]]
) -> tuple[str, ...]:
    """A sentence for each set of indicators that assume the same constants of the plant."""
    labels: dict[tuple[str, ...], list[str]] = {}
    for label, indicator in indicators.items():
        if names := assumed_constants(sources, indicator.options):
            labels.setdefault(names, []).append(label)
    return tuple(assumption_text(", ".join(of), names) for names, of in labels.items())


def plant_advice(sources: Sequence[RecordSource], channels: Collection[Channel]) -> tuple[str, ...]:
    """What the indicators that can use these channels assume of the plant; at most one sentence."""
    from hydrofdi.indicators import make_indicators

    labels: list[str] = []
    names: dict[str, None] = {}
    for label, indicator in make_indicators("all").items():
        if indicator.channels <= set(channels) and (own := assumed_constants(sources, indicator.options)):
            labels.append(label)
            names |= dict.fromkeys(own)
    if not labels:
        return ()
    return (
        f"{', '.join(labels)} take {', '.join(names)} of your actuator as options; without them they assume"
        " the nominal actuator of the paper",
    )


def assumption_text(label: str, names: Sequence[str]) -> str:
    """The sentence that names constants which nobody gave."""
    are = "is" if len(names) == 1 else "are"
    return (
        f"{label}: {', '.join(names)} {are} not given; the nominal actuator of the paper is assumed, so the"
        " numbers may be wrong for yours; give options in YAML, as"
        f" 'indicators: {{{label.split(',')[0]}: {{{names[0]}: …}}}}'"
    )


def constants_text(options: Section) -> str:
    """The constants of the plant with their values, ``piston_area = 633 mm^2``; empty if there are none."""
    return ", ".join(
        f"{name} = {shown_quantity(getattr(options, name), unit)}"
        for name, unit in plant_constants(options).items()
    )
