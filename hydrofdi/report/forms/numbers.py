"""Numbers for forms that know no NaN."""

from __future__ import annotations

import math


def finite(value: float) -> float | None:
    """The value, or None if it is NaN or infinite."""
    return value if math.isfinite(value) else None
