"""Cost of sensors: whole batches including features, compared with ideal sensors."""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from jobs import lane_jobs

from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.simulation.sensing import CHANNELS

RECORD = 20.0
"""Duration of the record of the timed batches [s]."""

LAG: dict[str, Any] = {"order": "second", "bandwidth": 200.0}
FILTER = {"measurement.anti_alias": 200.0}

SENSORS: dict[str, dict[str, Any]] = {
    "ideal": {},
    "noise of each sample, P1": {"pressure_1_sensor.noise": 2e3},
    "jitter": {"measurement.jitter": 1e-5},
    "lag, P1": {f"pressure_1_sensor.{name}": value for name, value in LAG.items()},
    "lag, all signals": {
        f"{channel.section}.{name}": value for channel in CHANNELS for name, value in LAG.items()
    },
    "anti-alias filter": FILTER,
    "  with noise density, P1": FILTER | {"pressure_1_sensor.noise_density": 20.0},
    "  with jitter": FILTER | {"measurement.jitter": 1e-5},
}


def measure_sensors(rounds: int) -> dict[str, dict[str, float]]:
    """Per choice: time per step and job [ns], and ratio to ideal sensors; medians."""
    batches = {
        name: [Job("run", run.with_values(values), coefficient) for run, coefficient in lane_jobs(RECORD)]
        for name, values in SENSORS.items()
    }
    for batch in batches.values():
        compute_columns(batch)
    times: dict[str, list[float]] = {name: [] for name in batches}
    ratios: dict[str, list[float]] = {name: [] for name in batches}
    for _ in range(rounds):
        for name, batch in batches.items():
            beside = _seconds(batches["ideal"])
            times[name].append(_seconds(batch))
            ratios[name].append(times[name][-1] / beside)
    job_steps = sum(job.parameters.record.n_step for job in batches["ideal"])
    return {
        name: {
            "ns_per_step_and_job": 1e9 * float(np.median(times[name])) / job_steps,
            "times_ideal_sensors": float(np.median(ratios[name])),
        }
        for name in batches
    }


def tell_sensors(rows: dict[str, dict[str, float]]) -> None:
    """Print the table to standard error."""
    print(f"\n{'sensors':26} {'ns per step and job':>20} {'times ideal':>12}", file=sys.stderr)
    for name, row in rows.items():
        figures = f"{row['ns_per_step_and_job']:20.2f} {row['times_ideal_sensors']:12.2f}"
        print(f"{name:26} {figures}", file=sys.stderr)


def _seconds(batch: list[Job]) -> float:
    start = time.perf_counter()
    compute_columns(batch)
    return time.perf_counter() - start


if __name__ == "__main__":
    tell_sensors(measure_sensors(7))
