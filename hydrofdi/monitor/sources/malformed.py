"""Lines or payloads that are not understood."""

from __future__ import annotations

import numpy as np

from hydrofdi.records.streams import Chunk


def malformed(what: str, text: str, reason: str) -> Chunk:
    """A line or a payload that is not understood: a sample that could not be read."""
    return Chunk(np.array([np.nan]), {}, {0: f"malformed {what} {text[:60]!r}: {reason}"})
