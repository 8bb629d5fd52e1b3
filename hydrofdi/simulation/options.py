"""Choices of the model that are made when the kernel is compiled, so that those not taken cost nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hydrofdi.config import RunParameters

Chosen = bool | None
"""True or None. The two have different types, so that each combination of choices is compiled by itself."""


class ModelOptions(NamedTuple):
    """What a run's model has beyond the paper's; the equations ask ``is not None``."""

    laminar_leakage: Chosen = None
    blended_leakage: Chosen = None
    ramped_leakage: Chosen = None
    intermittent_leakage: Chosen = None
    smooth_friction: Chosen = None

    @classmethod
    def of(cls, run: RunParameters) -> ModelOptions:
        """The choices of a run."""
        leakage = run.leakage
        return cls(
            laminar_leakage=leakage.law == "laminar" or None,
            blended_leakage=leakage.law == "blended" or None,
            ramped_leakage=leakage.onset in {"step", "ramp"} or None,
            intermittent_leakage=leakage.onset == "intermittent" or None,
            smooth_friction=run.friction.law == "smooth" or None,
        )


def group_by_options(runs: Sequence[RunParameters]) -> list[tuple[ModelOptions, list[int]]]:
    """The choices that occur, each with the positions of the runs that make them."""
    groups: dict[ModelOptions, list[int]] = {}
    for position, run in enumerate(runs):
        groups.setdefault(ModelOptions.of(run), []).append(position)
    return list(groups.items())
