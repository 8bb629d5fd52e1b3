"""Numbers of indicators, as detectors take them."""

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
    """An output of an indicator: one number, or all of those that it has.

    Attributes
    ----------
    indicator : Indicator
    output : str
        The first one that is a score, where it is empty.
    """

    indicator: Indicator[Any]
    output: str = ""

    @property
    def described(self) -> Output:
        """What the indicator says of the output.

        Raises
        ------
        ConfigError
            It has none of this name.
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
        """Such as ``dwt.d2``."""
        return f"{self.indicator.name}.{self.described.name}"

    def direction(self, chosen: Direction | None = None) -> Direction:
        """The direction of a leak: the chosen one, or that of the output.

        Raises
        ------
        ConfigError
            None is chosen, and that of the output depends on the actuator.
        """
        direction = chosen or self.described.direction
        if direction is None:
            raise ConfigError(
                f"choose the direction in which {self.label} raises an alarm: rising, falling or both"
            )
        return direction

    def of(self, records: RecordBatch) -> Array:
        """Its numbers, shape (n_record, n_number); NaN if a record has none."""
        return self._measured(records)[0]

    def of_healthy(self, records: RecordBatch) -> Array:
        """The same, of records from which something is learned.

        Raises
        ------
        NotStatedError
            No record has the number, with the reason of the first one.
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
    """Numbers of several outputs side by side, shape (n_record, n_number)."""
    return np.hstack([feature.of(records) for feature in features])
