"""Checks of a description of measured files, beyond the types of its values."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Mapping

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Channel
from hydrofdi.records.measured.columns import unit_mistake
from hydrofdi.records.measured.description.sections import ChannelConfig, MeasuredConfig
from hydrofdi.records.measured.forming import OWN_NAMES, fields_of, path_pattern
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.yaml_source import Source


def contradictions(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    """Mistakes that concern more than one key, with their lines."""
    yield from _sampling(config, source)
    yield from channel_mistakes(config.channels, source)
    yield from _needed_channels(config, source)
    yield from _names(config, source)
    yield from _labels(config, source)
    try:
        codecs.lookup(config.format.encoding)
    except LookupError:
        message = f"unknown encoding {config.format.encoding!r}; for example utf-8 or latin-1"
        yield source.mistake(("format", "encoding"), message)
    delimiter = config.format.delimiter
    if delimiter is not None and len(delimiter) > 1 and delimiter not in ("tab", "\\t", "space"):
        yield source.mistake(("format", "delimiter"), f"one character, tab or space; found {delimiter!r}")
    if delimiter in ('"', "\n", "\r"):
        yield source.mistake(("format", "delimiter"), f"{delimiter!r} cannot separate columns")
    if delimiter == config.format.decimal:
        yield source.mistake(("format", "delimiter"), f"{delimiter!r} is also the decimal sign")


def channel_mistakes(channels: Mapping[Channel, ChannelConfig], source: Source) -> Iterator[Issue]:
    """Mistakes in units, ranges and gains of columns, and what is given twice."""
    written: dict[Channel, str] = {}
    for name in source.data.get("channels") or ():
        if (first := written.setdefault(Channel(name), name)) != name:
            yield source.mistake(("channels", name), f"is given twice, as {first!r} too")
    of_column: dict[str | None, Channel] = {}
    for channel, column in channels.items():
        if column.column and (other := of_column.setdefault(column.column, channel)) != channel:
            yield source.mistake(
                ("channels", written.get(channel, channel.value)), f"has the column of {other}"
            )
        path = ("channels", written.get(channel, channel.value))
        if column.unit and (mistake := unit_mistake(column.unit, channel.unit)):
            yield source.mistake((*path, "unit"), mistake)
        try:
            column.plausible_range(channel.unit)
        except ValueError as error:
            yield source.mistake((*path, "range"), str(error))
        if column.gain == 0.0:
            yield source.mistake((*path, "gain"), "must not be zero")


def _sampling(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    if config.time is None and config.sampling_frequency is None:
        message = "is missing; give 'sampling_frequency: 1 kHz', or 'time: {column: …, unit: s}'"
        yield source.mistake(("sampling_frequency",), message)
    if config.time is not None and config.sampling_frequency is not None:
        yield source.mistake(("sampling_frequency",), "is given as well as 'time'; give only one of them")
    if config.resample is not None and config.time is None:
        yield source.mistake(("resample",), "needs 'time', a column of sampling instants")
    if config.time is not None and config.time.unit and (mistake := unit_mistake(config.time.unit, "s")):
        yield source.mistake(("time", "unit"), mistake)


def _needed_channels(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    needs = [
        (("segment",), config.segment is not None, Channel.PISTON_POSITION),
        (("limits", "shortest_stroke"), config.limits.shortest_stroke is not None, Channel.PISTON_POSITION),
        (("normalize",), config.normalize == "supply", Channel.SUPPLY_PRESSURE),
        (("normalize",), config.normalize == "hold", Channel.CHAMBER_1_PRESSURE),
        (("normalize",), config.normalize == "hold", Channel.CHAMBER_2_PRESSURE),
    ]
    for key in ("group", "label"):
        needs.append(((key,), "direction" in fields_of(getattr(config, key)), Channel.PISTON_POSITION))
    cycles = config.cycles
    if cycles is not None:
        needs.append((("cycles",), cycles.by == "edges", cycles.channel))
        needs.append((("cycles",), cycles.by == "reversals", Channel.PISTON_POSITION))
        if cycles.by == "period" and cycles.period is None:
            yield source.mistake(("cycles",), "needs a period")
    if config.segment is not None and config.segment.part == "impact" and config.segment.length is None:
        yield source.mistake(("segment",), "an impact needs a length, such as 0.5 s")
    for path, is_asked, channel in needs:
        if is_asked and channel not in config.channels:
            yield source.mistake(path, f"needs the channel {channel}")


def _labels(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    for key in ("healthy", "severity"):
        if getattr(config, key) and not config.label:
            yield source.mistake((key,), "needs 'label', which states the condition of each record")
    for label in config.severity:
        if label in config.healthy:
            yield source.mistake(("severity", label), "is a healthy label and cannot have a severity")


def _names(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    try:
        pattern = path_pattern(config.path)
    except re.error as error:
        yield source.mistake(("path",), f"is not a regular expression: {error}")
        return
    known = [*pattern.groupindex, *config.columns, *OWN_NAMES]
    for key in ("group", "label", "date"):
        for name in fields_of(getattr(config, key)):
            # a file has a date, but only its cycles have a direction
            if name not in known or (key, name) == ("date", "direction"):
                yield source.mistake((key,), f"unknown name {{{name}}}{nearest(name, known)}")
