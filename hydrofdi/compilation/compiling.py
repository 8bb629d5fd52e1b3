"""Compilation of kernels, cached on disk.

Numba's own cache checks only the file that defines a compiled function, not the equations inlined into it. So
the name of the cache folder contains a hash of all sources that the kernels of a package use.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from hydrofdi.physics.equation import EQUATIONS, FAST_MATH

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """Compile a kernel on its first call, or load it from the cache on disk."""
    return _on_first_call(function, fastmath=FAST_MATH, cached=True)


def strictly_compiled(function: _Function) -> _Function:
    """Compile like `compiled`, but with strict rounding, so that all lanes give identical bits."""
    return _on_first_call(function, fastmath=False, cached=True)


def _on_first_call(function: _Function, **options: Any) -> _Function:
    @cache
    def kernel() -> Any:
        return dispatcher(function, **options)

    @wraps(function)
    def call(*arguments: Any) -> object:
        return kernel()(*arguments)

    return cast(_Function, call)


def dispatcher(function: Callable[..., object], *, cached: bool = False, **options: Any) -> Any:
    """Numba dispatcher of a function: it compiles for each combination of argument types."""
    import numba

    settings: Any = numba.config
    previous = settings.CACHE_DIR
    folder = cache_directory(room_of(function)) if cached else None
    settings.CACHE_DIR = str(folder)
    try:
        _register_equations()
        options["cache"] = folder is not None
        compile_: Any = numba.njit(error_model="numpy", boundscheck=False, nogil=True, **options)
        return compile_(function)
    finally:
        settings.CACHE_DIR = previous


_INLINED = {"forceinline": True, "fastmath": FAST_MATH, "error_model": "numpy"} | dict.fromkeys(
    ("no_cpython_wrapper", "no_cfunc_wrapper"), True
)
"""Options of equations, which compiled code alone calls."""


def _register_equations() -> None:
    """Register all equations with the compiler that are not registered yet."""
    from numba.extending import register_jitable

    while EQUATIONS:
        register_jitable(**_INLINED)(EQUATIONS.pop())


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
    for file in sorted(file for each in rooms for file in (package / each).rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def is_dynamic(argument: Any) -> bool:
    """Whether machine code takes an argument; all others are constants of it."""
    return isinstance(argument, (np.ndarray, float, int, np.integer)) and not isinstance(argument, bool)
