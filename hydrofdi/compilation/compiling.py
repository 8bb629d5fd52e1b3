"""Where machine code is kept on disk: folders that this user alone can write.

The name of the folder contains a hash of all sources that the kernels of a package use: equations of other
files are inlined into them.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np


def room_of(function: Callable[..., object]) -> str:
    """Package of hydrofdi whose sources a function uses; ``simulation`` for functions from elsewhere."""
    parts = function.__module__.split(".")
    return parts[1] if parts[0] == "hydrofdi" and len(parts) > 1 else "simulation"


@cache
def cache_directory(room: str) -> Path | None:
    """Cache folder of the compiled kernels of a package in its present version; as `own_cache`."""
    return own_cache(f"kernel-{_source_hash(room)}")


def own_cache(name: str) -> Path | None:
    """A folder of the cache; None if there is no writable one that belongs to this user alone.

    Nothing is kept then.
    """
    folder = _cache_root() / name
    try:
        for made in (*reversed(folder.parents), folder):  # parents=True would ignore the mode
            made.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return None
    usable = stat.S_ISDIR(status.st_mode) and belongs_here(status) and os.access(folder, os.W_OK | os.X_OK)
    return folder if usable else None


def belongs_here(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user, and nobody else may write it."""
    return status.st_uid == os.geteuid() and not status.st_mode & 0o022


def _cache_root() -> Path:
    if own := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(own)
    user = os.environ.get("XDG_CACHE_HOME")
    home = Path(user) if user else Path(os.path.expanduser("~")) / ".cache"
    return home / "hydrofdi"


def _source_hash(room: str) -> str:
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    rooms = sorted({"compilation", "physics", room})
    modules = (file for each in rooms for file in package.glob(f"{each}.py"))
    for file in sorted([*modules, *(file for each in rooms for file in (package / each).rglob("*.py"))]):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def is_dynamic(argument: Any) -> bool:
    """Whether machine code takes an argument; all others are constants of it."""
    return isinstance(argument, (np.ndarray, float, int, np.integer)) and not isinstance(argument, bool)
