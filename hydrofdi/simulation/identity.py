"""The identity of a run."""

from __future__ import annotations

import hashlib

from hydrofdi.config import RunSpec
from hydrofdi.config.run_table.runs import Runs
from hydrofdi.physics import PHYSICS_VERSION


def run_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of the physics version and a run's request.

    Names, paths, worker counts and spellings of quantities do not enter.
    """
    return _identity(run.request_digest, physics_version)


def run_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``run_identity`` of many runs."""
    return tuple([_identity(digest, physics_version) for digest in runs.request_digests()])


def _identity(request_digest: bytes, physics_version: int) -> str:
    return hashlib.sha256(b"hydrofdi physics %d\n" % physics_version + request_digest).hexdigest()[:16]
