"""Tables of a check and of a calibration."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from hydrofdi.api.inspection import Inspection, Observability
from hydrofdi.api.selection import Convergence, LeakageTarget
from hydrofdi.report.table import Column, Table, quantity
from hydrofdi.report.wording import labels_text, shown_modulus
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE, readable_unit, two_digits, typeset
from hydrofdi.units import convert

_MOST_ROWS = 24
"""Most runs that have a row each; for more, such as a sample, the ranges are shown."""


def modes_table(found: Inspection) -> Table:
    """The hydraulic mode of each run, or the ranges of many runs."""
    modes, modulus = found.modes, shown_modulus()
    n_band = len(found.bands)
    conditions = [labels_text(mode.labels) for mode in modes]
    has_conditions = len({*conditions}) > 1
    bands = [_band_name(mode.level, n_band) if mode.status == "ok" else mode.status for mode in modes]

    column = partial(_column, modes)
    columns = (
        column("bulk_modulus", "Pa", f"EBM [{modulus.unit}]", "g", modulus.number),
        column("leakage_coefficient", "m^3.5/kg^0.5", "K_i [m³/s/√Pa]", ".3g"),
        column("mean_leakage_flow", "m^3/s", "leakage [L/min]", ".3g", _litres),
        column("piston_share", "1", "piston flow", ".1%"),
        column("leakage_flow_at_reference", "m^3/s", "at 8 MPa [L/min]", ".3g", _litres),
        column("frequency", "Hz", "f_h [Hz]", ".1f"),
        column("damping_ratio", "1", "ζ", ".4f"),
        Column("band", bands),
        column("octaves_to_edge", "1", "octaves to edge", ".2f"),
        column("stroke_share", "1", "stroke used", ".0%"),
        Column("conditions", conditions, is_text=True, is_shown=has_conditions),
    )
    if len(modes) <= _MOST_ROWS:
        return Table(columns, n_lead=3)
    names = Column("of_runs", ["least", "median", "largest"], title="of runs", is_text=True)
    numbers = [each for each in columns if each.unit]
    note = f"of {counted(len(modes), 'run')}; --json lists each"
    return Table((names, *map(_ranges, numbers)), notes=(note,))


def _column(
    of: Sequence[Any], name: str, unit: str, title: str, form: str, shown: Callable[[float], float] = float
) -> Column:
    values = [getattr(each, name) for each in of]
    return Column(name, values, unit, title, lambda value: _text(shown(value), form))


def _ranges(column: Column) -> Column:
    finite = column.array[np.isfinite(column.array)]
    values = np.quantile(finite, [0.0, 0.5, 1.0]).tolist() if finite.size else [math.nan] * 3
    return Column(column.name, values, column.unit, column.title, column.text)


def _text(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else HOLE


def _litres(flow: float) -> float:
    return convert(flow, "L/min")


def _band_name(level: int, n_level: int) -> str:
    if level == 0:
        return "above d1"
    return f"d{level}" if level <= n_level else f"below d{n_level}"


def unknowns_table(found: Observability) -> Table:
    """Standard deviations of the unknowns of an estimator before and after a record, in SI."""
    units = ["%" if each.unit == "1" else readable_unit(each.unit, each.before) for each in found.unknowns]
    scales = [
        convert(1.0, shown) if shown != each.unit else 1.0
        for each, shown in zip(found.unknowns, units, strict=True)
    ]

    def column(name: str) -> Column:
        values = [getattr(each, name) for each in found.unknowns]
        texts = [two_digits(value * scale) for value, scale in zip(values, scales, strict=True)]
        return Column(name, values, text=texts)

    return Table(
        (
            Column("unknown", [each.name for each in found.unknowns], is_text=True),
            column("before"),
            column("after"),
            Column("unit", [*map(typeset, units)], is_text=True),
        ),
        title=f"Standard deviations before and after {found.duration:g} s without a leak: {found.indicator}",
    )


def noise_table(found: Inspection) -> Table:
    """Noise of the chamber-1 pressure sensor in each level, and its share of the weakest run."""
    levels = found.noise
    return Table(
        (
            Column("level", [f"d{level}" for level in range(1, len(levels) + 1)], is_text=True),
            quantity("noise", [each.noise for each in levels], "Pa"),
            quantity("weakest_rms", [each.weakest_rms for each in levels], "Pa", "weakest run"),
            Column("share", [each.share for each in levels], text=partial(_text, form=".1%")),
        ),
        title="Noise of the chamber-1 pressure sensor",
    )


def convergence_table(found: Convergence) -> Table:
    """The change of the features from step to step."""
    n_level = len(found.changes[0])
    end = (
        f"no step down to {found.steps[-1]:g} s stays within {found.tolerance:g}"
        if found.good_enough is None
        else f"a step of {convert(found.good_enough, 'ms'):g} ms stays within {found.tolerance:g}"
    )
    steps = Column("step", found.steps, "s", "step [ms]", lambda step: f"{convert(step, 'ms'):g}")
    levels = (
        Column(f"d{level}", [change[level - 1] for change in found.changes], text=partial(_text, form=".1e"))
        for level in range(1, n_level + 1)
    )
    title = "Largest change of the detail RMS when the step is halved"
    return Table((steps, *levels), title=title, notes=(end,))


def targets_table(targets: Sequence[LeakageTarget]) -> Table:
    """Leakage flows with their coefficients."""
    column = partial(_column, targets)
    return Table((
        column("flow", "m^3/s", "mean leakage [L/min]", ".4g", _litres),
        column("coefficient", "m^3.5/kg^0.5", "K_i (orifice) [m³/s/√Pa]", ".6g"),
        column("laminar_coefficient", "m^3/(s*Pa)", "laminar [m³/(s·Pa)]", ".4g"),
        column("piston_share", "1", "of piston flow", ".2%"),
    ))  # fmt: skip
