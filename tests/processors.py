"""Another processor: what its results may differ by, and how to behave like the oldest that is supported.

``python -m tests.processors COMMAND …`` runs a command as on a processor of 2009 (x86-64-v2, the oldest that
NumPy supports): without AVX, AVX2, FMA and AVX-512 in compiled kernels, NumPy, OpenBLAS and the C library.
"""

import os
import sys
from typing import Any

import pytest

RELATIVE, ABSOLUTE = 1e-6, 1e-12
"""Largest difference of a number that a reader sees; decisions, counts and texts must not differ at all."""


def same(value: Any) -> Any:
    """What another processor may print in place of a JSON value."""
    if isinstance(value, dict):
        return {key: same(each) for key, each in value.items()}
    if isinstance(value, list):
        return [same(each) for each in value]
    return pytest.approx(value, rel=RELATIVE, abs=ABSOLUTE) if isinstance(value, float) else value


def oldest() -> dict[str, str]:
    """Environment of a process that behaves as on the oldest processor."""
    from numpy._core import _multiarray_umath as umath

    newer = (name for name in umath.__cpu_dispatch__ if umath.__cpu_features__.get(name))
    missing = ("AVX", "AVX2", "FMA", "FMA4", "AVX512F", "AVX512CD", "AVX512BW", "AVX512DQ", "AVX512VL")
    return os.environ | {
        "NUMBA_CPU_NAME": "x86-64-v2",
        "NUMBA_CPU_FEATURES": "",
        "NPY_DISABLE_CPU_FEATURES": " ".join(newer) or os.environ.get("NPY_DISABLE_CPU_FEATURES", ""),
        "OPENBLAS_CORETYPE": "Nehalem",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=" + ",".join(f"-{name}" for name in missing),
    }


if __name__ == "__main__":
    os.execvpe(sys.argv[1], sys.argv[1:], oldest())
