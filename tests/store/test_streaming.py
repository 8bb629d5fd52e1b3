"""Many records through ``measure`` in little memory."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from tests.conftest import sweep_in

FOUR = """\
name: many
record: {duration: 1 s}
store: {signals: pressures, dtype: float32}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-8]
    fluid.bulk_modulus: [551 MPa, 827 MPa]
"""

MEASURED = """
import re, sys
from hydrofdi.cli.app import main
try:
    main()
except SystemExit as end:
    peak = re.search(r"VmHWM:\\s*(\\d+) kB", open("/proc/self/status").read())[1]
    sys.stderr.write(f"\\n{end.code} {peak}\\n")
"""
"""Prints the exit code, and the peak of the resident memory in kB; ``ru_maxrss`` would count the parent's."""


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    return sweep_in(tmp_path_factory.mktemp("many"), FOUR)


def repeated(file: Path, path: Path, n_run: int) -> Path:
    """An experiment file with the runs of another, again and again, each with an identity of its own."""
    with h5py.File(file) as source, h5py.File(path, "w") as target:
        target.attrs.update(source.attrs)
        for name, held in source.items():
            rows = held.shape[0]
            if name in ("run_id", "record_id"):
                target.create_dataset(name, data=[f"{row:016x}" for row in range(n_run)])
            elif name in ("time", "level"):
                target.create_dataset(name, data=held[:])
            else:
                many = target.create_dataset(name, (n_run, *held.shape[1:]), held.dtype)
                block = np.concatenate([held[:]] * (1000 // rows))
                for first in range(0, n_run, len(block)):
                    many[first : first + len(block)] = block[: n_run - first]
    return path


def measured(file: Path, out: Path) -> int:
    """Measure in a process of its own; the peak of its resident memory [MB]."""
    command = [sys.executable, "-c", MEASURED, "measure", str(file), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1200, env=os.environ)
    code, peak = done.stderr.splitlines()[-1].split()
    assert code == "0", done.stderr
    return int(peak) // 1024


def test_memory_does_not_grow_with_the_records(four: SimpleNamespace, tmp_path: Path) -> None:
    few, more = (
        measured(repeated(four.file, tmp_path / f"{n_run}.h5", n_run), tmp_path / f"{n_run}.csv")
        for n_run in (1000, 20_000)
    )
    assert more < 500
    assert more - few < 40  # the chamber-1 pressures of the larger source alone are 80 MB
    with open(tmp_path / "20000.csv", encoding="utf-8") as lines:
        assert sum(1 for _ in lines) == 20_001
