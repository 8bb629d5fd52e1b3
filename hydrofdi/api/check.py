"""Checks of an experiment before it runs, and leakage coefficients of leakage flows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any

from hydrofdi.api.arguments import positive_of
from hydrofdi.api.experiments import Experiment, experiment_of
from hydrofdi.api.inspection import Inspection, inspect_experiment
from hydrofdi.api.notebook import html_sentences
from hydrofdi.api.plan_warnings import experiment_warnings
from hydrofdi.api.selection import Convergence, LeakageTarget, calibrate_flows, converge, select_runs
from hydrofdi.config.shown_values import shown_in
from hydrofdi.errors import ConfigError
from hydrofdi.units import parse_quantity


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
    refuse_flow(experiment)
    what = "a flow such as '0.12 L/min', or a number in m³/s"
    values = [positive_of("flows", flow, "m^3/s", what) for flow in flows]
    if not values:
        raise ConfigError("flows: name at least one, e.g. 0.12 L/min")
    return calibrate_flows(experiment_of(experiment, settings), values)


def refuse_flow(experiment: Experiment | None) -> None:
    """Raise a `ConfigError` if a leakage flow is in the place of an experiment file."""
    text = str(experiment) if isinstance(experiment, str | PathLike) else ""
    if not text or Path(text).exists():
        return
    try:
        parse_quantity(text, "m^3/s")
    except ValueError:
        return
    raise ConfigError(f"{text!r} is a leakage flow, not an experiment file; write flows={text!r} (--flow)")
