"""Checks of an experiment before it runs, and leakage coefficients of leakage flows, with their tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from math import isfinite, nan
from numbers import Real
from typing import Any

import numpy as np

from hydrofdi.api.arguments import positive_of
from hydrofdi.api.experiments import Experiment, experiment_of
from hydrofdi.api.inspection import Inspection, Observability, inspect_experiment
from hydrofdi.api.notebook import html_sentences
from hydrofdi.api.selection import Convergence, LeakageTarget, calibrate_flows, converge, select_runs
from hydrofdi.api.warnings import experiment_warnings
from hydrofdi.config.shown_values import shown_in
from hydrofdi.errors import ConfigError
from hydrofdi.report.table import Column, Table, quantity
from hydrofdi.report.wording import labels_text, shown_modulus
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE, readable_unit, two_digits, typeset
from hydrofdi.units import convert

_MOST_ROWS = 24
"""Most runs that have a row each; for more, such as a sample, the ranges are shown."""


@dataclass(frozen=True)
class Check:
    """Findings on an experiment, as `hydrofdi.check` returns them. True if there are no problems.

    Attributes
    ----------
    inspection : Inspection
        Step, hydraulic mode and bands, record, leakage, stroke and sensor noise.
    convergence : Convergence or None
        Change of the features when the step is halved; None if this was not requested.
    settings : tuple of str
        Warnings of the settings: strange values, parameters without effect, small studies.
    """

    inspection: Inspection
    convergence: Convergence | None
    settings: tuple[str, ...]

    @property
    def problems(self) -> list[str]:
        """Problems that make the results wrong."""
        problems = [*self.inspection.problems]
        if self.convergence is not None and self.convergence.good_enough is None:
            problems.append("none of the tested steps is short enough")
        return problems

    @property
    def warnings(self) -> list[str]:
        """Warnings to keep in mind when you read the results."""
        return list(dict.fromkeys([*self.settings, *self.inspection.warnings]))

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi check --json`` prints; None in place of what is not finite."""
        record = asdict(self.inspection) | {"binding": self.inspection.binding}
        record |= {"problems": self.problems, "warnings": self.warnings}
        if self.convergence is not None:
            record["convergence"] = asdict(self.convergence) | {"good_enough": self.convergence.good_enough}
        cleaned: dict[str, Any] = _plain(record)
        return cleaned

    def __bool__(self) -> bool:
        return not self.problems

    def _sentences(self) -> list[str]:
        lines = [f"problem: {each}" for each in self.problems]
        return lines + [f"warning: {each}" for each in self.warnings]

    def __repr__(self) -> str:
        return "\n".join(self._sentences()) or "no warnings"

    def _repr_html_(self) -> str:
        title = "Results would be wrong" if self.problems else "No problems"
        return html_sentences(title, self._sentences() or ["no warnings"])


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def check(
    experiment: Experiment | None = None,
    /,
    *,
    halve_step: bool = False,
    tolerance: float = 1e-3,
    **settings: Any,
) -> Check:
    """Look at an experiment before running it, as ``hydrofdi check`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        By default the nominal actuator.
    halve_step : bool
        Whether to halve the step until the detail RMS no longer change.
    tolerance : float
        Accepted relative change of a detail RMS.
    **settings
        As in `hydrofdi.simulate`.

    Raises
    ------
    ConfigError
        With every mistake, or a leakage flow that cannot be reached.

    Examples
    --------
    >>> import hydrofdi
    >>> found = hydrofdi.check(duration="2 s", step="1 ms")
    >>> bool(found)
    False
    >>> found.problems[0]
    'the step of 0.001 s is too long for the friction zone: ...'
    """
    accepted = positive_of("tolerance", tolerance, "1", "a relative change such as 0.001")
    loaded = experiment_of(experiment, settings)
    selection = select_runs(loaded)
    with shown_in(loaded.units):
        return Check(
            inspect_experiment(selection),
            converge(selection.jobs, accepted) if halve_step else None,
            tuple(experiment_warnings(loaded, selection.distinct)),
        )


def calibrate(
    experiment: Experiment | None = None,
    /,
    *,
    flows: str | float | Sequence[str | float] = (),
    **settings: Any,
) -> list[LeakageTarget]:
    """The leakage coefficients of mean leakage flows, under the conditions of the baseline.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        By default the nominal actuator.
    flows : str, float, or sequence of them
        Mean leakage flows such as ``"0.12 L/min"``, or numbers in SI [m³/s].
    **settings
        As in `hydrofdi.simulate`.

    Raises
    ------
    ConfigError
        With every mistake, or a flow that cannot be reached.

    Examples
    --------
    >>> import hydrofdi
    >>> (target,) = hydrofdi.calibrate(flows=["0.12 L/min"], duration="2 s")
    >>> f"{target.coefficient:.1e} m³/s/√Pa"
    '...e-10 m³/s/√Pa'
    """
    if isinstance(flows, str | Real) or not isinstance(flows, Iterable):
        flows = [flows]
    what = "a flow such as '0.12 L/min', or a number in m³/s"
    values = [positive_of("flows", flow, "m^3/s", what) for flow in flows]
    if not values:
        raise ConfigError("flows: name at least one, e.g. 0.12 L/min")
    return calibrate_flows(experiment_of(experiment, settings), values)


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
    values = np.quantile(finite, [0.0, 0.5, 1.0]).tolist() if finite.size else [nan] * 3
    return Column(column.name, values, column.unit, column.title, column.text)


def _text(value: float, form: str) -> str:
    return format(value, form) if isfinite(value) else HOLE


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
