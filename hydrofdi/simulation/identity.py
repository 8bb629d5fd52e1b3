"""The identity of a run."""

from __future__ import annotations

import hashlib

from hydrofdi.config import RunSpec
from hydrofdi.physics import PHYSICS_VERSION


def run_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of a run's request and the physics version.

    Names, paths, worker counts and spellings of quantities do not enter.
    """
    text = f"hydrofdi physics {physics_version}\n{run.request}"
    return hashlib.sha256(text.encode()).hexdigest()[:16]
