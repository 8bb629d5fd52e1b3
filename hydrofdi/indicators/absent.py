"""Placeholders for indicators of stored experiments whose package is no longer installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, Channel, RecordBatch


class AbsentIndicator(Indicator[Any]):
    """Placeholder for an indicator that is not installed: stored results are read without it."""

    name = "absent"
    version = 0
    summary = "An indicator that is not installed."
    source = "none"

    def __init__(self, reason: str) -> None:
        super().__init__()
        self.reason = reason

    @property
    def channels(self) -> frozenset[Channel]:
        """None."""
        return frozenset()

    @property
    def outputs(self) -> tuple[Output, ...]:
        """None."""
        return ()

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message that the indicator is not installed."""
        return self.reason

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """No values."""
        return {}
