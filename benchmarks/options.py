"""Cost of each model option: time per step, also relative to all options off, and time to compile."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from jobs import lane_jobs

from hydrofdi.simulation.inputs import Inputs
from hydrofdi.simulation.kernel import advance_lanes
from hydrofdi.simulation.lanes import N_PAPER_SAMPLED, SAMPLED, WIDTH, ModelOptions, pack_lanes

CHOICES: dict[str, dict[str, Any]] = {
    "off": {},
    "laminar leakage": {"leakage.law": "laminar"},
    "blended leakage": {"leakage.law": "blended"},
    "ramped leakage": {"leakage.onset": "ramp"},
    "smooth friction": {"friction.law": "smooth"},
    "LuGre friction": {"friction.law": "lugre"},
    "free air": {"fluid.law": "free_air"},
    "limited spool": {"valve.largest_opening": 40e-6, "valve.largest_speed": 0.05},
    "lapped valve": {"valve.lap": 2e-6},
    "unequal edges": {"supply_1_edge.lap": 1e-6},
    "hysteresis": {"valve.hysteresis": 0.05},
    "shifted null": {"valve.null_offset": 0.4e-6},
    "end stops": {"actuator.end_stops": "elastic"},
    "load force": {"load.constant_force": 100.0},
    "supply droop": {"supply.droop": "first_order"},
    "closed loop": {"control.law": "pid"},
    "worn edges": {"valve.edge_rounding": 1e-6},
    "supply ripple": {"supply.ripple": 0.01},
    "return line": {"supply.return_resistance": 2e9},
    "uneven friction": {"friction.pressure_slope": 5e-8},
    "warm oil": {"fluid.temperature_rise": 10.0},
    "dragged leakage": {"leakage.drag": 2e6},
    "scored bore": {"leakage.scored_width": 10e-3},
    "hoses": {"actuator.hose_volume": 50e-6},
    "foundation": {"actuator.foundation_stiffness": 20e6},
    "unequal chambers": {"actuator.piston_area_2": 380e-6},
    "inclined": {"actuator.inclination": 0.5},
    "measured feedback": {"control.law": "pid", "control.feedback": "measured"},
}
CHOICES["all compatible options"] = {
    name: value for choice in CHOICES.values() for name, value in choice.items()
}

N_STEP = 10_000


class LaneRun:
    """Full lanes with some options, which can be advanced over the same steps repeatedly."""

    def __init__(self, values: dict[str, Any]) -> None:
        jobs = lane_jobs(2.0)
        runs = [run.with_values(values) for run, _ in jobs]
        inputs = Inputs(runs[:1], runs[0].record)
        chunk = inputs.advance(0, N_STEP)
        self.options = ModelOptions.of(runs[0])
        self.drive = chunk.references if self.options.closed_loop else chunk.stages
        self.loads = chunk.loads
        self.lanes = pack_lanes(runs, [coefficient for _, coefficient in jobs])
        self.record = runs[0].record
        n_row = len(SAMPLED) if self.options.samples_more else N_PAPER_SAMPLED
        self.samples = np.empty((N_STEP // self.record.steps_per_sample, n_row, WIDTH))
        self.columns = np.zeros(WIDTH, dtype=np.int64)

    def advance(self) -> None:
        advance_lanes(
            self.lanes, self.drive, self.columns, self.loads, self.columns, 1, self.record.step,
            self.record.steps_per_sample, 20, self.samples, 0, self.options,
        )  # fmt: skip


def measure_options(rounds: int) -> dict[str, dict[str, float]]:
    """Per option: time per step and job [ns], ratio to all options off, and compile time [s]."""
    runs = {name: LaneRun(values) for name, values in CHOICES.items()}
    off = LaneRun({})
    for run in runs.values():
        run.advance()
    times: dict[str, list[float]] = {name: [] for name in CHOICES}
    ratios: dict[str, list[float]] = {name: [] for name in CHOICES}
    for _ in range(rounds):
        for name, run in runs.items():
            beside = warm_seconds(off.advance)
            times[name].append(warm_seconds(run.advance))
            ratios[name].append(times[name][-1] / beside)
    compilation = compilation_times()
    return {
        name: {
            "ns_per_step_and_job": 1e9 * float(np.median(times[name])) / (N_STEP * WIDTH),
            "times_all_off": float(np.median(ratios[name])),
            "compilation_seconds": compilation[name],
        }
        for name in CHOICES
    }


def warm_seconds(act: Callable[[], None]) -> float:
    """Time of a function with its arrays in the cache [s]."""
    act()
    start = time.perf_counter()
    act()
    return time.perf_counter() - start


def compilation_times() -> dict[str, float]:
    """Time to compile the lane kernel for each option, in a process with an empty cache [s]."""
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"NUMBA_CACHE_DIR": cache}
        done = subprocess.run([sys.executable, __file__], env=environment, capture_output=True, check=True)
    times: dict[str, float] = json.loads(done.stdout)
    return times


def _compile_all() -> dict[str, float]:
    times = {}
    for name, values in CHOICES.items():
        run = LaneRun(values)
        start = time.perf_counter()
        run.advance()
        times[name] = time.perf_counter() - start
    return times


if __name__ == "__main__":
    print(json.dumps(_compile_all()))
