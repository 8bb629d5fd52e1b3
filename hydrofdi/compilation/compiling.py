"""Compilation of kernels, cached on disk.

Numba's own cache checks only the file that defines a compiled function, not the equations inlined into it. So
the name of the cache folder contains a hash of all sources that the kernels of a package use.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

from hydrofdi.physics.equation import EQUATIONS, FAST_MATH

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """Compile a kernel on its first call, or load it from the cache on disk."""
    return _on_first_call(function, fastmath=FAST_MATH, cache=True)


def strictly_compiled(function: _Function) -> _Function:
    """Compile like `compiled`, but with strict rounding, so that all lanes give identical bits."""
    return _on_first_call(function, fastmath=False, cache=True)


def _on_first_call(function: _Function, **options: Any) -> _Function:
    @cache
    def kernel() -> Any:
        return dispatcher(function, **options)

    @wraps(function)
    def call(*arguments: Any) -> object:
        return kernel()(*arguments)

    return cast(_Function, call)


def dispatcher(function: Callable[..., object], **options: Any) -> Any:
    """Numba dispatcher of a function: it compiles for each combination of argument types."""
    import numba

    settings: Any = numba.config
    previous = settings.CACHE_DIR
    settings.CACHE_DIR = str(cache_directory(room_of(function)))
    try:
        _register_equations()
        compile_: Any = numba.njit(error_model="numpy", boundscheck=False, nogil=True, **options)
        return compile_(function)
    finally:
        settings.CACHE_DIR = previous


def _register_equations() -> None:
    """Register all equations with the compiler that are not registered yet."""
    from numba.extending import register_jitable

    while EQUATIONS:
        register_jitable(forceinline=True, fastmath=FAST_MATH, error_model="numpy")(EQUATIONS.pop())


def room_of(function: Callable[..., object]) -> str:
    """Package of hydrofdi whose sources a function uses; ``simulation`` for functions from elsewhere."""
    parts = function.__module__.split(".")
    return parts[1] if parts[0] == "hydrofdi" and len(parts) > 1 else "simulation"


@cache
def cache_directory(room: str) -> Path:
    """Cache folder of the compiled kernels of a package in its present version.

    It is in the user's cache directory, or in a temporary directory if that is not writable.
    """
    name = f"kernel-{_source_hash(room)}"
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


def _source_hash(room: str) -> str:
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    rooms = sorted({"compilation", "physics", room})
    for file in sorted(file for each in rooms for file in (package / each).rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
