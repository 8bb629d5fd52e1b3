"""Whole processes: start-up, first compilation, and a large sweep."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from jobs import LARGEST_LEAKAGE_COEFFICIENT

HYDROFDI = str(Path(sysconfig.get_path("scripts")) / "hydrofdi")
IMPORT_NUMPY = [sys.executable, "-c", "import numpy"]

COMMANDS = (
    "simulate", "check", "plan small.yaml", "--help", "report --help", "schema", "status results/small",
    "why results/small 1", "report results/small",
)  # fmt: skip
SMALL = """\
name: small
record: {duration: 2 s}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], fluid.bulk_modulus: [551 MPa, 827 MPa]}}
"""


def bytecode(folder: str) -> dict[str, str]:
    """Environment in which Python caches bytecode, as it does by default."""
    return {"PYTHONPYCACHEPREFIX": str(Path(folder) / "bytecode"), "PYTHONDONTWRITEBYTECODE": ""}


def seconds(command: list[str], cwd: str, **environment: str) -> float:
    """Wall time of a process [s]."""
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, cwd=cwd, env=os.environ | environment)
    return time.perf_counter() - start


def start_up(repetitions: int) -> dict[str, dict[str, float]]:
    """Median and minimum wall time of each command [s]; every round runs all commands."""
    commands = {"import numpy": IMPORT_NUMPY} | {
        f"hydrofdi {line}": [HYDROFDI, *line.split()] for line in COMMANDS
    }
    times: dict[str, list[float]] = {name: [] for name in commands}
    with tempfile.TemporaryDirectory() as folder:
        environment = bytecode(folder)
        (Path(folder) / "small.yaml").write_text(SMALL)
        seconds([HYDROFDI, "sweep", "small.yaml"], folder, **environment)
        for name in commands:
            seconds(commands[name], folder, **environment)
        for _ in range(repetitions):
            for name, command in commands.items():
                times[name].append(seconds(command, folder, **environment))
    return {name: {"median": float(np.median(all_)), "least": min(all_)} for name, all_ in times.items()}


def first_compilation(repetitions: int) -> list[float]:
    """Wall times of ``simulate`` with an empty cache minus one with the resulting cache [s]."""
    differences = []
    for _ in range(repetitions):
        with tempfile.TemporaryDirectory() as folder:
            command = [HYDROFDI, "simulate", "--set", "record.duration=2 s"]
            cold = seconds(command, folder, NUMBA_CACHE_DIR=folder)
            differences.append(cold - seconds(command, folder, NUMBA_CACHE_DIR=folder))
    return differences


def large_sweep(n_job: int, workers: int) -> dict[str, float]:
    """Run a sweep over K_i and EBM without stored signals: wall time [s] and peak memory [bytes]."""
    side = round(n_job**0.5)
    experiment: dict[str, Any] = {
        "name": "large",
        "store": {"signals": "none"},
        "sweep": {
            "grid": {
                "leakage.internal_coefficient": [
                    LARGEST_LEAKAGE_COEFFICIENT * k / side for k in range(1, side + 1)
                ],
                "fluid.bulk_modulus": np.linspace(551e6, 827e6, side).tolist(),
            }
        },
    }
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "large.yaml").write_text(json.dumps(experiment))
        command = [HYDROFDI, "sweep", "large.yaml", "--workers", str(workers), "--json"]
        start = time.perf_counter()
        process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        memory = MemoryWatch(process.pid)
        output, _ = process.communicate()
        wall = time.perf_counter() - start
        memory.stop()
    summary = json.loads(output)
    if summary["failed"] or process.returncode:
        raise RuntimeError(f"the sweep failed: {summary}")
    return {"jobs": summary["planned"], "seconds": wall, "peak_memory": memory.peak}


class MemoryWatch:
    """Sampled peak memory of a process and all its descendants; shared pages count once (Linux)."""

    def __init__(self, pid: int) -> None:
        self.peak = float("nan")
        self._pid = pid
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._done.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._done.wait(0.25):
            sizes = [_proportional_size(pid) for pid in _family(self._pid)]
            self.peak = np.fmax(self.peak, sum(sizes)) if sizes else self.peak


def _family(root: int) -> list[int]:
    parents = {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(status.parent.name)] = int(fields[1])
    family = [root] if root in parents else []
    for pid in family:
        family += [child for child, parent in parents.items() if parent == pid]
    return family


def _proportional_size(pid: int) -> int:
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return sum(1024 * int(line.split()[1]) for line in lines if line.startswith("Pss:"))
