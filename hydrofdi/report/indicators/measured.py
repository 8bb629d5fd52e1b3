"""The outputs of indicators as an experiment stores them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DWT
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.contract import Output
from hydrofdi.settings.readable import readable_unit
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout.names import OBSTACLE
from hydrofdi.units import convert

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredOutput:
    """An output over all runs.

    Attributes
    ----------
    output : Output
    values : ndarray, shape (n_run, *dims)
        In the unit of the output; NaN if a run has none.
    """

    output: Output
    values: Array

    @property
    def title(self) -> str:
        """Its name, and the dimensions of its mean."""
        over = " and ".join(self.output.dims)
        return f"{self.output.name} (mean over {over})" if over else self.output.name

    @property
    def shown_unit(self) -> str:
        """The unit in which a person reads it; ``1`` if it has none."""
        known = np.abs(self.means[np.isfinite(self.means)])
        return readable_unit(self.output.unit, float(known.max())) if known.size else self.output.unit

    def shown(self, values: Array) -> Array:
        """Numbers in the unit of the output, in `shown_unit`."""
        unit = self.shown_unit
        return values if unit == self.output.unit else values * convert(1.0, unit)

    @property
    def means(self) -> Array:
        """The mean over all its dimensions, shape (n_run,); NaN if there is no number."""
        flat = self.values.reshape(len(self.values), -1)
        count = np.isfinite(flat).sum(axis=1)
        with np.errstate(invalid="ignore"):
            means: Array = np.where(np.isfinite(flat), flat, 0.0).sum(axis=1) / count
        return means


@dataclass(frozen=True)
class MeasuredIndicator:
    """An indicator and its outputs over all runs.

    Attributes
    ----------
    label : str
        Its name in the experiment.
    indicator : Indicator
    outputs : tuple of MeasuredOutput
    obstacles : ndarray of str, shape (n_run,), or None
        Reason why a run has no number, empty if it has one; None if the file has no reasons.
    """

    label: str
    indicator: Indicator[Any]
    outputs: tuple[MeasuredOutput, ...]
    obstacles: NDArray[Any] | None = None

    def variable(self, output: MeasuredOutput) -> str:
        """``label.output``."""
        return f"{self.label}.{output.output.name}"

    def obstacle(self, row: int) -> str:
        """Reason why a run has no number; a general one if the file has none."""
        return str("" if self.obstacles is None else self.obstacles[row]) or self.indicator.absence

    @property
    def has_number(self) -> NDArray[np.bool_]:
        """Whether a run has any number, shape (n_run,)."""
        means = np.stack([output.means for output in self.outputs])
        return np.asarray(np.isfinite(means).any(axis=0))


def measured_indicators(data: ExperimentData) -> tuple[MeasuredIndicator, ...]:
    """The stored indicators of an experiment, except that of the details."""
    measured = (
        measured_indicator(label, indicator, data.columns)
        for label, indicator in data.experiment.indicator_choice.made(data.experiment.wavelet).items()
        if label != DWT
    )
    return tuple(indicator for indicator in measured if indicator.outputs)


def measured_indicator(
    label: str, indicator: Indicator[Any], columns: Mapping[str, Array]
) -> MeasuredIndicator:
    """An indicator with those of its outputs that are among the columns."""
    outputs = (
        MeasuredOutput(output, columns[f"{label}.{output.name}"])
        for output in indicator.outputs
        if f"{label}.{output.name}" in columns
    )
    return MeasuredIndicator(label, indicator, tuple(outputs), columns.get(f"{label}{OBSTACLE}"))
