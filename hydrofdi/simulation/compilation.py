"""Compilation of the kernel, cached on disk.

Numba's own cache watches only the file that holds a compiled function, not the equations that are inlined
into it. So the cache folder is named by a hash of all sources that enter a kernel.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba

from hydrofdi.physics.equation import FAST_MATH

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """Compile a kernel on its first call, or load it from the cache on disk."""
    return _compiled(function, FAST_MATH)


def strictly_compiled(function: _Function) -> _Function:
    """As `compiled`, with every operation rounded as it is written, so that all lanes get the same bits."""
    return _compiled(function, False)


def _compiled(function: _Function, fast_math: set[str] | bool) -> _Function:
    settings: Any = numba.config
    previous = settings.CACHE_DIR
    settings.CACHE_DIR = str(cache_directory())
    try:
        compile_: Any = numba.njit(
            fastmath=fast_math, error_model="numpy", boundscheck=False, nogil=True, cache=True
        )
        kernel: _Function = compile_(function)
        return kernel
    finally:
        settings.CACHE_DIR = previous


@cache
def cache_directory() -> Path:
    """Folder of the compiled kernels of these sources; in the user's cache, or else in a temporary folder."""
    name = f"kernel-{_source_hash()}"
    for root in _cache_roots():
        folder = root / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK | os.X_OK):
            return folder
    return Path(tempfile.mkdtemp(prefix="hydrofdi-"))


def _cache_roots() -> list[Path]:
    if own := os.environ.get("NUMBA_CACHE_DIR"):
        return [Path(own)]
    user = os.environ.get("XDG_CACHE_HOME")
    home = Path(user) if user else Path(os.path.expanduser("~")) / ".cache"
    return [home / "hydrofdi"]


def _source_hash() -> str:
    package = Path(__file__).parent.parent
    files = sorted((package / "physics").glob("*.py")) + sorted((package / "simulation").glob("*.py"))
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
