"""Indicator outputs as features of detectors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.indicators import Indicator, Output, measure
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.suggestions import nearest


@dataclass(frozen=True, eq=False)
class Feature:
    """An output of an indicator: a number or an array.

    Attributes
    ----------
    indicator : Indicator
    output : str
        Name of the output; by default the first one that is a score.
    """

    indicator: Indicator[Any]
    output: str = ""

    @property
    def described(self) -> Output:
        """Declaration of the output.

        Raises
        ------
        ConfigError
            The indicator has no output of this name.
        """
        outputs = {each.name: each for each in self.indicator.outputs}
        if not self.output:
            return next(each for each in self.indicator.outputs if each.is_score)
        if self.output not in outputs:
            hint = nearest(self.output, [*outputs])
            raise ConfigError(f"{self.indicator.name} has no output {self.output!r}{hint}")
        return outputs[self.output]

    @property
    def label(self) -> str:
        """Label, such as ``dwt.d2``."""
        return f"{self.indicator.name}.{self.described.name}"

    def direction(self, chosen: Direction | None = None) -> Direction:
        """Direction of change by a leak: the chosen one, or that of the output.

        Raises
        ------
        ConfigError
            No direction is chosen, and that of the output depends on the actuator.
        """
        direction = chosen or self.described.direction
        if direction is None:
            raise ConfigError(
                f"choose the direction in which {self.label} raises an alarm: rising, falling or both"
            )
        return direction

    def of(self, records: RecordBatch) -> Array:
        """Values of the output, shape (n_record, n_number); NaN if a record has none."""
        return self._measured(records)[0]

    def of_healthy(self, records: RecordBatch) -> Array:
        """The same for training records.

        Raises
        ------
        NotStatedError
            No record has a value; the message gives the reason of the first record.
        """
        numbers, obstacles = self._measured(records)
        if not np.isfinite(numbers).any():
            reason = next((each for each in obstacles if each), self.indicator.absence)
            raise NotStatedError(f"no healthy record has {self.label}: {reason}")
        return numbers

    def _measured(self, records: RecordBatch) -> tuple[Array, tuple[str | None, ...]]:
        measures = measure(records, {"it": self.indicator})
        numbers = measures.values[f"it.{self.described.name}"]
        return numbers.reshape(records.n_record, -1), measures.obstacles["it"]


def features_of(features: Sequence[Feature], records: RecordBatch) -> Array:
    """Values of several outputs, concatenated, shape (n_record, n_number)."""
    return np.hstack([feature.of(records) for feature in features])
