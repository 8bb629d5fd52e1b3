"""Indicator outputs as features of detectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators import Indicator, Output
from hydrofdi.settings.messages import nearest


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
