"""Numbers over the start phases as plain data."""

from __future__ import annotations

from typing import Any

from hydrofdi.papers.maddahi2015.standings import PhaseCount
from hydrofdi.report.forms.numbers import finite


def phases_record(count: PhaseCount, quantity: str) -> dict[str, Any]:
    """In how many phases something holds, and the range of the number behind it."""
    numbers = {"least": count.least, "mean": count.mean, "largest": count.largest}
    return {
        "phases": {
            "held": count.held,
            "of": count.of,
            quantity: {name: finite(value) for name, value in numbers.items()},
        }
    }


def labels_record(labels: dict[str, Any]) -> dict[str, Any]:
    """Further varied parameters, if there are any."""
    return {"labels": labels} if labels else {}
