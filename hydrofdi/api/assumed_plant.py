"""What indicators take for granted about the plant behind measured records."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from hydrofdi.indicators import Indicator
from hydrofdi.indicators.nominal_actuator import constants_not_given, plant_constants
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.records import Channel, RecordSource
from hydrofdi.records.measured.source import HeldSource, MeasuredSource
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
    for label, usual in make_indicators("all").items():
        for indicator, text in ((usual, label), (_by_command(usual), f"{label} (spool: command)")):
            own = () if indicator is None else assumed_constants(sources, indicator.options)
            if indicator is not None and own and indicator.channels <= set(channels):
                labels.append(text)
                names |= dict.fromkeys(own)
                break
    if not labels:
        return ()
    return (
        f"{', '.join(labels)} take {', '.join(names)} of your actuator as options; without them they assume"
        " the nominal actuator of the paper",
    )


def _by_command(indicator: Indicator[Any]) -> Indicator[Any] | None:
    """The same with the spool position from the input voltage; None if it has no such option."""
    if getattr(indicator.options, "spool", "") != "measured":
        return None
    return sound_indicator(indicator.name, {"spool": "command"})


def assumption_text(label: str, names: Sequence[str]) -> str:
    """The sentence that names constants which nobody gave."""
    are = "is" if len(names) == 1 else "are"
    them = f"it as an option of {label}" if len(names) == 1 else f"them as options of {label}"
    return (
        f"{label}: {', '.join(names)} {are} not given; the nominal actuator of the paper is assumed, so the"
        f" numbers may be wrong for yours; give {them}"
    )


def constants_text(options: Section) -> str:
    """The constants of the plant with their values, ``piston_area = 633 mm^2``; empty if there are none."""
    return ", ".join(
        f"{name} = {shown_quantity(getattr(options, name), unit)}"
        for name, unit in plant_constants(options).items()
    )
