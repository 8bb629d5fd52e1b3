"""Kernels whose machine code is cached on disk, so that later processes run them without numba.

Loading numba and its cache takes longer than a run. Machine code that does not use numba's runtime can be
linked by llvmlite alone, in milliseconds. The process that compiles a kernel runs the same code.

It is kept in folders that this user alone can write. Their names contain a hash of all sources that the
kernels of a package use: equations of other files are inlined into them.
"""

from __future__ import annotations

import ctypes
import hashlib
import linecache
import os
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from hydrofdi.compilation.symbols import is_dynamic, recorded
from hydrofdi.physics import EQUATIONS, FAST_MATH


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
    modules = (file for name in rooms for file in package.glob(f"{name}.py"))
    for file in sorted([*modules, *(file for name in rooms for file in (package / name).rglob("*.py"))]):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


_Kernel = TypeVar("_Kernel", bound=Callable[..., None])
_Call = Callable[..., object]

_SYMBOL = "kernel"
_LIBRARY_FUNCTIONS = {"exp", "log", "pow", "sqrt", "sin", "cos", "tanh", "fmod", "memset", "memcpy"}
"""Functions that machine code may call: they are in the C library of every process."""

_C_ORDER, _FORTRAN_ORDER, _ALIGNED, _WRITEABLE = 0x1, 0x2, 0x100, 0x400
"""Array flags that determine the array type; an array in C order is not checked for Fortran order."""

_DIGEST_SIZE = 16


def kernel(function: _Kernel) -> _Kernel:
    """Run a function that fills arrays as machine code, from the cache or else compiled by numba.

    Each combination of argument types has its own machine code.
    """
    return _on_first_call(function, partial(_compile, fast_math=FAST_MATH))


def strict_kernel(function: _Kernel) -> _Kernel:
    """The same with strict rounding, so that all lanes give identical bits."""
    return _on_first_call(function, partial(_compile, fast_math=False))


def recorded_kernel(function: _Kernel) -> _Kernel:
    """Run a function of `symbols` as machine code, from the cache or else recorded.

    Each combination of argument types, and of the values of other arguments, has its own machine code. Arrays
    that it fills must not overlap others.
    """
    return _on_first_call(function, _recorded_code, is_dynamic)


def _on_first_call(
    function: _Kernel,
    compile_: Callable[[_Kernel, tuple[Any, ...]], bytes],
    is_passed: Callable[[Any], bool] = lambda argument: True,
) -> _Kernel:
    """Arguments that are not passed are constants of the machine code."""
    calls: dict[tuple[Any, ...], _Call] = {}

    @wraps(function)
    def call(*arguments: Any) -> None:
        passed = tuple(filter(is_passed, arguments))
        key = tuple(_type_of(argument) if is_passed(argument) else argument for argument in arguments)
        if key not in calls:
            calls[key] = _prepared(function, key, passed, lambda: compile_(function, arguments))
        calls[key](*passed)

    return cast(_Kernel, call)


def _prepared(
    function: _Kernel, key: tuple[Any, ...], arguments: tuple[Any, ...], compiled: Callable[[], bytes]
) -> _Call:
    if not _can_link():
        raise OSError("this process cannot resolve the C library")
    package, _, module = function.__module__.partition(".")
    # the name of the folder covers the sources of hydrofdi alone
    is_own = package == "hydrofdi"
    folder = cache_directory(module.partition(".")[0] if is_own else "simulation")
    source = "" if is_own else "".join(linecache.getlines(function.__code__.co_filename))
    name = f"{function.__name__}-{_digest(repr((source, key, *_machine())).encode()).hex()}.o"
    code = _read(folder / name) if folder else None
    if code is None:
        code = compiled()
        if folder:
            _write(folder / name, code)
    return _link(code, arguments)


def _recorded_code(function: _Kernel, arguments: tuple[Any, ...]) -> bytes:
    from llvmlite import binding

    machine = _target_machine()
    module = binding.parse_assembly(recorded(function, arguments, _SYMBOL))
    module.verify()
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    tuning = binding.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    builder = binding.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


@cache
def _can_link() -> bool:
    """Initialise llvmlite; return whether machine code can resolve the C library in this process."""
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    with suppress(RuntimeError):
        binding.load_library_permanently("")
    return all(map(binding.address_of_symbol, _LIBRARY_FUNCTIONS))


def _type_of(value: Any) -> Any:
    """Hashable type of an argument, as the compiler distinguishes it."""
    if isinstance(value, np.ndarray):
        flags = value.flags.num
        order = _C_ORDER if flags & _C_ORDER else flags & _FORTRAN_ORDER
        return value.dtype, value.ndim, order | flags & (_ALIGNED | _WRITEABLE)
    return tuple(map(_type_of, value)) if isinstance(value, tuple) else type(value).__name__


@cache
def _processor() -> tuple[str, str]:
    """Name and features of the processor that machine code is made for; variables of numba state another."""
    from llvmlite import binding

    name = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES")
    return name, binding.get_host_cpu_features().flatten() if features is None else features


@cache
def _machine() -> tuple[str, ...]:
    """Properties of this machine and its libraries that machine code depends on."""
    return version("numba"), version("llvmlite"), *_processor()


_BARE = dict.fromkeys(("no_cpython_wrapper", "no_cfunc_wrapper"), True)
"""Options of what machine code alone calls."""


def dispatcher(function: Callable[..., object], **options: Any) -> Any:
    """Numba dispatcher of a function, which may call all equations."""
    import numba
    from numba.extending import register_jitable

    while EQUATIONS:
        register_jitable(forceinline=True, fastmath=FAST_MATH, error_model="numpy", **_BARE)(EQUATIONS.pop())
    compile_: Any = numba.njit(error_model="numpy", boundscheck=False, nogil=True, **options)
    return compile_(function)


def _compile(function: _Kernel, arguments: tuple[Any, ...], fast_math: Any) -> bytes:
    """Compile a function for arguments of these types; it may not allocate memory."""
    import numba
    from llvmlite import binding

    signature = tuple(map(numba.typeof, arguments))
    compiling = dispatcher(function, fastmath=fast_math, _nrt=False, **_BARE)
    compiling.compile(signature)
    module = binding.parse_assembly(compiling.inspect_llvm(signature))
    needed = {item.name for item in (*module.functions, *module.global_variables) if item.is_declaration}
    if lacking := {name for name in needed if not name.startswith("llvm.")} - _LIBRARY_FUNCTIONS:
        raise TypeError(
            f"{function.__name__} needs {', '.join(sorted(lacking))}, which a kernel may not call"
        )
    (entry,) = (
        item
        for item in module.functions
        if item.linkage is binding.Linkage.external and not item.is_declaration
    )
    entry.name = _SYMBOL
    return bytes(_target_machine().emit_object(module))


def _target_machine() -> Any:
    from llvmlite import binding

    name, features = _processor()
    return binding.Target.from_default_triple().create_target_machine(
        cpu=name, features=features, opt=3, jit=True, codemodel="jitdefault"
    )


def _link(code: bytes, arguments: tuple[Any, ...]) -> _Call:
    """Link machine code and return a callable with numba's calling convention."""
    from llvmlite import binding

    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _target_machine())
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    pointer = ctypes.c_void_p
    prototype = ctypes.CFUNCTYPE(ctypes.c_int32, pointer, pointer, *map(_c_type, _parts(arguments)))
    entry = prototype(engine.get_function_address(_SYMBOL))
    results = (ctypes.c_void_p * 2)()
    result, failure = ctypes.addressof(results), ctypes.addressof(results) + ctypes.sizeof(pointer)

    def call(*arguments: Any) -> None:
        status = entry(result, failure, *_parts(arguments))
        if status:
            raise RuntimeError(f"a kernel failed with status {status}")

    call.kept = engine, results  # type: ignore[attr-defined]  # must live as long as the function
    return call


def _c_type(part: Any) -> Any:
    """ctypes type of one of `_parts`; an address is passed like an integer."""
    if part is None:
        return ctypes.c_void_p
    if isinstance(part, float):
        return ctypes.c_double
    return ctypes.c_bool if isinstance(part, bool) else ctypes.c_int64


def _parts(values: tuple[Any, ...]) -> list[Any]:
    """Arguments flattened for machine code.

    An array becomes owner, parent, sizes, data, shape and strides.
    """
    parts: list[Any] = []
    for value in values:
        if isinstance(value, np.ndarray):
            parts += (None, None, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)
        elif isinstance(value, tuple):
            parts += _parts(value)
        else:
            parts.append(value)
    return parts


def _digest(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_DIGEST_SIZE).digest()


def _read(path: Path) -> bytes | None:
    """Read machine code; None if it is missing or damaged, or if others may have written it."""
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
            content = file.read() if belongs_here(os.fstat(file.fileno())) else b""
    except OSError:
        return None
    code = content[_DIGEST_SIZE:]
    return code if content[:_DIGEST_SIZE] == _digest(code) else None


def _write(path: Path, code: bytes) -> None:
    """Write machine code to the cache; if that fails, the next process compiles again."""
    with suppress(OSError), tempfile.TemporaryDirectory(dir=path.parent) as folder:
        part = Path(folder) / path.name
        part.touch(mode=0o600)
        part.write_bytes(_digest(code) + code)
        os.replace(part, path)
