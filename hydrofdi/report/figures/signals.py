"""Signals of runs over time, in panels; the channels of one record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.report.figures import style
from hydrofdi.store import names
from hydrofdi.store.shards import Columns
from hydrofdi.transforms.wavelet import detail_coefficients
from hydrofdi.units import convert

Panels = Mapping[str, tuple[str, str]]
"""Signal → label of its axis, and the unit in it."""

PANELS: Panels = {
    names.INPUT_VOLTAGE: ("$u$ [V]", "V"),
    "piston_position": ("$x_p$ [mm]", "mm"),
    names.CHAMBER_1_PRESSURE: ("$P_1$ [MPa]", "MPa"),
    names.CHAMBER_2_PRESSURE: ("$P_2$ [MPa]", "MPa"),
    "internal_leakage_flow": ("$q_{il}$ [L/min]", "L/min"),
}

_MOVING_PANELS: Panels = {
    names.VALVE_SUPPLY_PRESSURE: ("$P_s$ [MPa]", "MPa"),
    names.LOAD_FORCE: ("$F_L$ [N]", "N"),
}
"""Shown if an option of the model makes them vary."""

_READABLE = {"Pa": "MPa", "m": "mm", "m/s": "mm/s", "V": "V"}
_MOST_TITLE = 60


@matplotlib.rc_context(style.SETTINGS)
def draw_signals(
    columns: Columns, wavelet: Any, title: str, chosen: Sequence[names.Variable] = (), start: float = 0.0
) -> Figure:
    """Input, stroke, pressures, leakage flow and d2 of P_1 of a run over time [s], and signals that vary.

    Or those that are chosen, and no detail.
    """
    if names.CHAMBER_1_PRESSURE not in columns:
        raise ReportError("the signals of the run are not stored; set store: {signals: all} and sweep again")
    known = {**PANELS, **_MOVING_PANELS}
    if chosen:
        units = {each.name: _READABLE.get(each.units, each.units) for each in chosen}
        panels = {name: known.get(name, (f"{name} [{unit}]", unit)) for name, unit in units.items()}
        return style.shown(draw_beside(columns, [title], None, panels, start))
    held = {name: about for name, about in known.items() if name in columns}
    usual = {name: about for name, about in held.items() if name in PANELS or np.ptp(columns[name][0]) > 0.0}
    return style.shown(draw_beside(columns, [title], wavelet, usual, start))


def draw_beside(
    columns: Columns, titles: list[str], wavelet: Any, panels: Panels = PANELS, start: float = 0.0
) -> Figure:
    """The same signals of one or two runs beside each other, with the reference of a controller."""
    time, level = columns[names.TIME], min(2, wavelet.levels) if wavelet else 0
    labels = [*(label for label, _ in panels.values()), *([f"$d_{level}$ of $P_1$ [kPa]"] if level else [])]
    width = 3.6 * len(titles) + (0.0 if len(titles) > 1 else 3.4)
    figure = Figure(figsize=(width, 2.0 + len(labels)), layout="constrained")
    axes = figure.subplots(len(labels), len(titles), sharex=True, sharey="row", squeeze=False)
    for row, (title, color) in enumerate(zip(titles, (style.BLUE, style.ORANGE), strict=False)):
        lines = [(name, time, convert(1.0, unit) * columns[name][row]) for name, (_, unit) in panels.items()]
        if level:
            pressure = columns[names.CHAMBER_1_PRESSURE][row]
            instants, details = detail_coefficients(pressure, wavelet, level, time)
            lines.append(("", instants, 1e-3 * details))
        for axis, (name, x, y) in zip(axes[:, row], lines, strict=True):
            axis.plot(x[x >= start], y[x >= start], color=color, linewidth=0.7)
            reference = columns.get(names.REFERENCE_POSITION)
            if name == "piston_position" and reference is not None and np.isfinite(reference[row]).any():
                ink, values = style.INK if len(titles) > 1 else style.ORANGE, 1e3 * reference[row][x >= start]
                axis.plot(x[x >= start], values, "--", color=ink, linewidth=0.7, label="reference")
                style.legend_above(axis)
        axes[0, row].set_title(title)
        style.time_axis(axes[-1, row], time[time >= start])
    for axis, label in zip(axes[:, 0], labels, strict=True):
        axis.set_ylabel(label)
    figure.align_ylabels(axes[:, 0])
    return figure


@matplotlib.rc_context(style.SETTINGS)
def draw_record(record: RecordBatch) -> Figure:
    """Channels of the first record of a batch."""
    panels = _panels(record)
    if record.n_time < 2 or not any(np.isfinite(samples[0]).any() for samples in record.channels.values()):
        raise ReportError("the record has no channel that can be drawn")
    figure = Figure(figsize=(10.0, 0.8 + 1.25 * len(panels)), layout="constrained")
    figure.suptitle(_title(record), x=0.01, ha="left", fontsize=10)
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, channels in zip(axes, panels, strict=True):
        for index, channel in enumerate(channels):
            factor = 1.0 if channel in record.relative else convert(1.0, _READABLE[channel.unit])
            samples, label = factor * record[channel][0], _words(channel).removesuffix(" pressure")
            axis.plot(record.time, samples, **style.series(index), linewidth=0.7, label=label)
        unit = record.unit(channels[0])
        axis.set_ylabel("[-]" if unit == "1" else f"[{_READABLE.get(unit, unit)}]")
        axis.set_title("pressure" if channels[0].is_pressure else _words(channels[0]))
        if channels[0].is_pressure:
            style.legend_above(axis, len(channels))
    style.time_axis(axes[-1], record.time, 8)
    return style.shown(figure)


def _title(record: RecordBatch) -> str:
    label = f", {record.labels[0]}" if record.labels and record.labels[0] else ""
    rate = f"{record.sampling_frequency:g} Hz, {record.n_time} samples"
    name = record.record_ids[0]
    return f"{name if len(name) <= _MOST_TITLE else '…' + name[-_MOST_TITLE:]}{label}: {rate}"


def _panels(record: RecordBatch) -> list[list[Channel]]:
    """Channels of each panel: pressures with the same unit share a panel, each other channel has its own."""
    pressures = [channel for channel in record.channels if channel.is_pressure]
    scaled = [channel for channel in pressures if channel not in record.relative]
    counts = [channel for channel in pressures if channel in record.relative]
    others = [[channel] for channel in record.channels if not channel.is_pressure]
    return [panel for panel in (scaled, counts) if panel] + others


def _words(channel: Channel) -> str:
    return channel.value.replace("_", " ")
