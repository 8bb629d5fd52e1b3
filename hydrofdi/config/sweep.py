"""The ``sweep`` section: which parameters vary."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from hydrofdi.config.quantities import Section


class SweepConfig(Section):
    """Parameter grid."""

    grid: dict[str, list[Any]] = Field(default_factory=dict)
    """Dotted parameter → its values; the runs are all combinations, the last axis varying fastest."""
