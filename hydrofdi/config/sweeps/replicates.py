"""The ``replicates`` section: healthy actuators that show the variation without a fault."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.config.sweeps.distributions import quantiles
from hydrofdi.config.sweeps.sample import Distribution
from hydrofdi.settings.quantities import Section


class ReplicatesConfig(Section):
    """Independent replicates of every healthy run, each with its own sensor noise and its own draw."""

    count: Annotated[int, Field(strict=True, ge=0, le=10_000)] = 0
    """Number of replicates of each healthy run. With 2 or more, δ is also computed against their mean and
    compared with the range of the replicates' own δ, each against the mean of the other replicates."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of the draws."""

    over: dict[str, Distribution] = Field(default_factory=dict)
    """Dotted parameter → its distribution, as in ``sample``: normal variation between actuators and days.
    Drawn independently for each replicate."""

    def draws(self, n_healthy: int) -> list[dict[str, object]]:
        """Parameter values of each replicate: all replicates of the first healthy run, then of the next."""
        generator = np.random.default_rng(self.seed)
        unit = generator.random((n_healthy * self.count, len(self.over)))
        columns = {name: quantiles(law, unit[:, k]) for k, (name, law) in enumerate(self.over.items())}
        return [{name: values[k] for name, values in columns.items()} for k in range(len(unit))]
