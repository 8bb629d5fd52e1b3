"""Signals of runs and records over time, in panels; a score over days."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hydrofdi.errors import ReportError
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.report.figures import BLUE, GREY, INK, ORANGE, SETTINGS, legend_above, series, shown, time_axis
from hydrofdi.settings.messages import convert
from hydrofdi.store import names
from hydrofdi.store.shards import Columns
from hydrofdi.transforms import detail_coefficients

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


@matplotlib.rc_context(SETTINGS)
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
        return shown(draw_beside(columns, [title], None, panels, start))
    held = {name: about for name, about in known.items() if name in columns}
    usual = {name: about for name, about in held.items() if name in PANELS or np.ptp(columns[name][0]) > 0.0}
    return shown(draw_beside(columns, [title], wavelet, usual, start))


def draw_beside(
    columns: Columns, titles: list[str], wavelet: Any, panels: Panels = PANELS, start: float = 0.0
) -> Figure:
    """The same signals of one or two runs beside each other, with the reference of a controller."""
    time, level = columns[names.TIME], min(2, wavelet.levels) if wavelet else 0
    labels = [*(label for label, _ in panels.values()), *([f"$d_{level}$ of $P_1$ [kPa]"] if level else [])]
    width = 3.6 * len(titles) + (0.0 if len(titles) > 1 else 3.4)
    figure = Figure(figsize=(width, 2.0 + len(labels)), layout="constrained")
    axes = figure.subplots(len(labels), len(titles), sharex=True, sharey="row", squeeze=False)
    for row, (title, color) in enumerate(zip(titles, (BLUE, ORANGE), strict=False)):
        lines = [(name, time, convert(1.0, unit) * columns[name][row]) for name, (_, unit) in panels.items()]
        if level:
            lines.append(("", *details(columns[names.CHAMBER_1_PRESSURE][row], wavelet, level, time)))
        for axis, (name, x, y) in zip(axes[:, row], lines, strict=True):
            axis.plot(x[x >= start], y[x >= start], color=color, linewidth=0.7)
            reference = columns.get(names.REFERENCE_POSITION)
            if name == "piston_position" and reference is not None and np.isfinite(reference[row]).any():
                ink, values = INK if len(titles) > 1 else ORANGE, 1e3 * reference[row][x >= start]
                axis.plot(x[x >= start], values, "--", color=ink, linewidth=0.7, label="reference")
                legend_above(axis)
        axes[0, row].set_title(title)
        time_axis(axes[-1, row], time[time >= start])
    for axis, label in zip(axes[:, 0], labels, strict=True):
        axis.set_ylabel(label)
    figure.align_ylabels(axes[:, 0])
    return figure


def details(pressure: Any, wavelet: Any, level: int, time: Any) -> tuple[Any, Any]:
    """Instants [s] and coefficients [kPa] of a level of P_1."""
    instants, coefficients = detail_coefficients(pressure, wavelet, level, time)
    return instants, 1e-3 * coefficients


@matplotlib.rc_context(SETTINGS)
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
            axis.plot(record.time, samples, **series(index), linewidth=0.7, label=label)
        unit = record.unit(channels[0])
        axis.set_ylabel("[-]" if unit == "1" else f"[{_READABLE.get(unit, unit)}]")
        axis.set_title("pressure" if channels[0].is_pressure else _words(channels[0]))
        if channels[0].is_pressure:
            legend_above(axis, len(channels))
    time_axis(axes[-1], record.time, 8)
    return shown(figure)


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


Interval = tuple[float, float, float]
"""Value, lower and upper end."""


@matplotlib.rc_context(SETTINGS)
def draw_trend(
    title: str,
    label: str,
    points: tuple[Array, Array, NDArray[np.bool_]],
    levels: tuple[Array, Array],
    onset: Interval | None,
    limit: float | None,
    reached: Interval | None,
    *,
    time_unit: str = "",
) -> Figure:
    """Draw a trend.

    Parameters
    ----------
    points : tuple of ndarray, shape (n,)
        Time, values, and whether each is used.
    levels : tuple of ndarray, shape (n_time,) and (3, n_time)
        Time; lower end, median and upper end of the level.
    onset, reached : Interval, optional
        Ends of `reached` may be infinite.
    time_unit : str
        Unit of all instants; days since 1970 if empty.
    """
    time, values, is_in = points
    instants, (low, level, high) = levels
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    axis: Any = figure.subplots()
    x = np.asarray if time_unit else _dates
    axis.plot(x(time[is_in]), values[is_in], "o", color=GREY, markersize=3, label="points")
    if not is_in.all():
        axis.plot(x(time[~is_in]), values[~is_in], "x", color=GREY, markersize=4, label="left out")
    axis.plot(x(instants), level, color=BLUE, linewidth=1.4, label="level")
    axis.fill_between(x(instants), low, high, color=BLUE, alpha=0.2, linewidth=0)
    edges = [instants[0], instants[-1]]
    if onset is not None:
        axis.axvspan(*x(onset[1:]), color=ORANGE, alpha=0.15, linewidth=0, label="onset")
        axis.axvline(x(onset[:1])[0], color=ORANGE, linestyle=":")
    if limit is not None:
        axis.axhline(limit, color=ORANGE, linestyle="--", linewidth=1.0, label="limit")
    if limit is not None and reached is not None and math.isfinite(reached[1]):
        ends = [max(reached[1], edges[0]), min(reached[2], edges[1])]
        axis.plot(x(ends), [limit, limit], color=ORANGE, linewidth=4.0, alpha=0.8, label="limit reached")
        if math.isfinite(reached[0]):
            axis.plot(x(reached[:1]), [limit], "D", color=ORANGE, markersize=5)
    if edges[1] > time[-1]:
        axis.axvline(x(time[-1:])[0], color=GREY, linewidth=0.6)
    _frame(axis, values[is_in], level, limit)
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    axis.set(ylabel=label, xlim=tuple(x(edges)))
    if time_unit:
        axis.set_xlabel(f"time [{time_unit}]")
    else:
        from matplotlib import dates

        locator: Any = dates.AutoDateLocator()  # type: ignore[no-untyped-call]
        axis.xaxis.set_major_locator(locator)
        axis.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]
    legend_above(axis, 6)
    return shown(figure)


def _dates(days: Array | Sequence[float]) -> Any:
    return (np.asarray(days) * 86400.0).astype("datetime64[s]")


def _frame(axis: Any, values: Array, level: Array, limit: float | None) -> None:
    """Limits of the axis: what is known, and the limit; an interval beyond them is cut off."""
    known = [*values.tolist(), *level.tolist(), *([] if limit is None else [limit])]
    low, high = min(known), max(known)
    if limit is not None:
        far = max(abs(limit - float(np.median(values))), float(np.ptp(values)))
        high = min(high, max(limit, float(values.max())) + 0.5 * far)
        low = max(low, min(limit, float(values.min())) - 0.5 * far)
    room = 0.08 * (high - low or 1.0)
    axis.set_ylim(low - room, high + room)
