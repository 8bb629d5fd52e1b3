"""Provenance of a sweep, stored next to the data and never inside it."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import socket
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.seeds import seeds_of
from hydrofdi.errors import without_credentials
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.files import write_whole_text

_FILE = "provenance.json"
_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def environment_record(experiment: ExperimentConfig) -> dict[str, Any]:
    """Current configuration, command, code, libraries and machine."""
    return {
        "started": now(),
        "command": [without_credentials(argument) for argument in sys.argv],
        "configuration": without_contents(json.loads(experiment.model_dump_json())),
        "seeds": seeds_of(experiment),
        "physics": PHYSICS_VERSION,
        "git": _git_state(Path(__file__).parent),
        "python": platform.python_version(),
        "libraries": dict(sorted({item.name: item.version for item in distributions()}.items())),
        "machine": {
            "host": socket.gethostname(),
            "system": platform.platform(),
            "processor": _processor(),
            "cores": os.cpu_count(),
        },
        "threads": {name: os.environ[name] for name in _THREAD_VARIABLES if name in os.environ},
    }


def add_provenance(directory: Path, record: dict[str, Any]) -> None:
    """Append the provenance record of a sweep to the earlier records.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    write_whole_text(directory / _FILE, json.dumps([*read_provenance(directory), record], indent=2))


def read_provenance(directory: Path) -> list[dict[str, Any]]:
    """Provenance records of all sweeps on an experiment's folder."""
    try:
        return list(json.loads((directory / _FILE).read_text()))
    except (OSError, ValueError):
        return []


def read_costs(directory: Path) -> dict[str, float]:
    """Label of an indicator → CPU time per record [s], from the latest sweep that measured it."""
    measured = [record["costs"] for record in read_provenance(directory) if record.get("costs")]
    return dict(measured[-1]) if measured else {}


def now() -> str:
    """Current UTC time in ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _git_state(folder: Path) -> dict[str, Any] | None:
    """Commit of the code and hash of uncommitted changes; None if the folder is not a checkout."""
    try:
        commit = _git(folder, "rev-parse", "HEAD").strip()
        difference = _git(folder, "diff", "HEAD")
        untracked = _git(folder, "ls-files", "--others", "--exclude-standard")
    except (OSError, subprocess.SubprocessError):
        return None
    is_dirty = bool(difference.strip() or untracked.strip())
    digest = hashlib.sha256((difference + untracked).encode()).hexdigest() if is_dirty else None
    return {"commit": commit, "dirty": is_dirty, "difference_sha256": digest}


def _git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor()
