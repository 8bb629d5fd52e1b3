"""Identities of records and runs."""

from __future__ import annotations

import hashlib

from hydrofdi.config.run_table.runs import Runs, RunSpec
from hydrofdi.physics import PHYSICS_VERSION


def record_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """First 16 hexadecimal digits of the SHA-256 of the physics version and all that determines a record.

    This includes plant, drive, sensors and replicate, but not the analysis, names, paths, worker counts or
    spellings of quantities.
    """
    return _of_record(run.record_digest, physics_version)


def run_identity(run: RunSpec, physics_version: int = PHYSICS_VERSION) -> str:
    """Hash of the identity of a run's record and its deviations from the default analysis.

    With the default analysis, it is the identity of the record.
    """
    return _of_run(record_identity(run, physics_version), run.analysis_text)


def record_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``record_identity`` of many runs."""
    return tuple([_of_record(digest, physics_version) for digest in runs.record_digests()])


def run_identities(runs: Runs, physics_version: int = PHYSICS_VERSION) -> tuple[str, ...]:
    """``run_identity`` of many runs."""
    return identities_of_analyses(runs, record_identities(runs, physics_version))


def identities_of_analyses(runs: Runs, records: tuple[str, ...]) -> tuple[str, ...]:
    """``run_identity`` of many runs, from the identities of their records."""
    if runs.are_analysed_by_default:
        return records
    return tuple([_of_run(*pair) for pair in zip(records, runs.analysis_texts(), strict=True)])


def _of_record(digest: bytes, physics_version: int) -> str:
    return hashlib.sha256(b"hydrofdi physics %d\n" % physics_version + digest).hexdigest()[:16]


def _of_run(record_id: str, analysis: str) -> str:
    if not analysis:
        return record_id
    return hashlib.sha256(f"hydrofdi run\n{record_id}\n{analysis}".encode()).hexdigest()[:16]
