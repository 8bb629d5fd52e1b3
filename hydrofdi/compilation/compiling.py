"""Compilation of kernels, cached on disk.

Numba's own cache watches only the file that holds a compiled function, not the equations that are inlined
into it. So the cache folder is named by a hash of all sources that enter the kernels of a room.
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
    """As `compiled`, with every operation rounded as it is written, so that all lanes get the same bits."""
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
    """Numba's function that compiles for each combination of argument types."""
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
    """Tell the compiler which functions it may inline; later ones are announced with the next kernel."""
    from numba.extending import register_jitable

    while EQUATIONS:
        register_jitable(forceinline=True, fastmath=FAST_MATH, error_model="numpy")(EQUATIONS.pop())


def room_of(function: Callable[..., object]) -> str:
    """The room of the package whose sources enter a function; another package has the simulation's."""
    parts = function.__module__.split(".")
    return parts[1] if parts[0] == "hydrofdi" and len(parts) > 1 else "simulation"


@cache
def cache_directory(room: str) -> Path:
    """Folder of the compiled kernels of a room with its present sources.

    It lies in the user's cache, or else in a temporary folder.
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
