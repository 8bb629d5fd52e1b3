"""The identity of a run."""

from __future__ import annotations

import hashlib

from hydrofdi.config import RunSpec
from hydrofdi.physics import PHYSICS_VERSION


def run_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of the physics version and a run's request.

    Names, paths, worker counts and spellings of quantities do not enter.
    """
    return hashlib.sha256(b"hydrofdi physics %d\n" % physics_version + run.request_digest).hexdigest()[:16]
