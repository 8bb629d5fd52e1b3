"""The ``load`` section: a force on the piston; the spring is ``actuator.load_stiffness``."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hydrofdi.settings.quantities import SI, Section


class LoadConfig(Section):
    """Force against positive motion of the piston."""

    constant_force: Annotated[float, SI("N", usual=("0.01 N", "10 MN"))] = 0.0
    """Constant force [N]. None in the paper."""

    random_force: Annotated[float, SI("N", least=0, usual=("0.01 N", "10 MN"))] = 0.0
    """Largest magnitude of an additional pseudo-random force [N]: seeded levels, each held for a period."""

    random_period: Annotated[float, SI("s", above=0, usual=("1 ms", "1 h"))] = 0.5
    """Time that each level of the pseudo-random force is held [s]. A choice."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of the pseudo-random force."""

    @property
    def is_present(self) -> bool:
        """Whether there is a force at all."""
        return self.constant_force != 0.0 or self.random_force != 0.0
