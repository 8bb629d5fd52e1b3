"""The features of an experiment over all its runs: changes of the details, and outputs of indicators."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.analysis import DWT
from hydrofdi.report.indicators.measured import measured_indicators
from hydrofdi.report.runs.changes import baseline_changes
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.units import convert

_SIZE = "RMS of "


@dataclass(frozen=True)
class Feature:
    """A number of each run.

    Attributes
    ----------
    name : str
        ``δd1``, or ``label.output`` of an indicator.
    unit : str
        Unit for people, such as ``%`` or ``kPa``; empty if it has none.
    values : ndarray, shape (n_run,)
        In `unit`; NaN if a run has none.
    own_unit : str
        SI unit, or ``%`` of a change.
    """

    name: str
    unit: str
    values: NDArray[np.float64]
    own_unit: str = "%"

    def own(self, value: float) -> float:
        """A number in `unit`, in `own_unit`."""
        return value if self.unit in ("", self.own_unit) else value / convert(1.0, self.unit)

    @property
    def header(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def is_detail(self) -> bool:
        """Whether it comes from the details of P_1 and not from a further indicator."""
        return self.is_change or self.name.startswith(_SIZE)

    @property
    def is_change(self) -> bool:
        """Whether it is a change against a healthy run."""
        return self.name.startswith("δ")


def detail_changes(data: ExperimentData, *, matched: bool) -> tuple[Feature, ...]:
    """δ [%] of the details against one of the two baselines; empty if each run is its own baseline."""
    against = data.matched_baseline if matched else data.fixed_baseline
    others = (against != names.NO_BASELINE) & (against != np.arange(data.n_run))
    if DWT not in data.experiment.indicators or not others.any():
        return ()
    levels = baseline_changes(data)[matched].T
    return tuple(Feature(f"δd{level}", "%", values) for level, values in enumerate(levels, 1))


def detail_sizes(data: ExperimentData) -> tuple[Feature, ...]:
    """RMS of the details [kPa]."""
    if DWT not in data.experiment.indicators:
        return ()
    levels = data.columns[names.DETAIL_RMS].T * convert(1.0, "kPa")
    return tuple(Feature(f"{_SIZE}d{level}", "kPa", values, "Pa") for level, values in enumerate(levels, 1))


def indicator_features(data: ExperimentData) -> Iterator[Feature]:
    """Outputs of the further indicators, except standard errors, that differ between any two runs."""
    for measured in measured_indicators(data):
        for output in (each for each in measured.outputs if not each.output.name.endswith("_error")):
            means, unit = output.means, output.shown_unit
            known = means[np.isfinite(means)]
            if known.size and np.ptp(known) > 0.0:
                title = f"{measured.label}.{output.title}"
                yield Feature(title, "" if unit == "1" else unit, output.shown(means), output.output.unit)
