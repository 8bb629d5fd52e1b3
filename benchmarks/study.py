"""Measure a study: records of 20 s with all cheap indicators and no signals, compared with the kernel alone.

    python benchmarks/study.py [--records 10000]

Reports processor time of one process, which other programs affect little. Prints JSON; nothing is asserted.
"""

import argparse
import json
import resource
import tempfile
import time
from pathlib import Path

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.execution import compute
from hydrofdi.execution.plan import plan_sweep
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.store.results import read_results
from hydrofdi.studies.reading import read_study

STUDY = """\
name: study
pressure_1_sensor: {{noise: 5 kPa, lowest: 0 bar, highest: 250 bar, bits: 12}}
pressure_2_sensor: {{noise: 5 kPa, lowest: 0 bar, highest: 250 bar, bits: 12}}
position_sensor: {{noise: 10 µm}}
spool_sensor: {{noise: 1.1 µm}}
study:
  population:
    over:
      fluid.bulk_modulus: {{uniform: ±20 %}}
      friction.scale: {{uniform: ±30 %}}
      friction.viscous: {{uniform: ±30 %}}
      supply.pressure: {{uniform: ±5 %}}
  healthy: {{fit: {tenth}, test: {tenth}}}
  faults: {{leakage.internal_flow: {{logspace: [0.01 L/min, 1 L/min, 8]}}, each: {tenth}, fit: 0}}
detection: {{indicators: all}}
"""


def experiment_of(folder, n_record):
    """Make a study of `n_record` records."""
    file = folder / "study.yaml"
    file.write_text(STUDY.format(tenth=n_record // 10))
    return load_experiment(file)


def swept(experiment, out):
    """Processor time of a sweep in this process, and of its kernel [s]."""
    original, spent = compute.compute_columns, []

    def simulate(*arguments, **options):
        start = time.process_time()
        trajectory = simulate_batch(*arguments, **options)
        spent.append(time.process_time() - start)
        return trajectory

    compute.compute_columns = lambda jobs, **options: original(jobs, simulate, **options)
    start = time.process_time()
    run_sweep(experiment, out, InProcessEngine())
    compute.compute_columns = original
    return time.process_time() - start, sum(spent)


def seconds_of(act):
    """Processor time of a function [s], and its result."""
    start = time.process_time()
    result = act()
    return time.process_time() - start, result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=10_000)
    parser.add_argument("--planned", type=int, default=25_000, help="records that are planned, not simulated")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=".") as name:
        folder = Path(name)
        large = experiment_of(folder, arguments.planned)
        expanding, _ = seconds_of(lambda: expand_runs(large))
        planning, _ = seconds_of(lambda: plan_sweep(large, folder / "nowhere"))
        small = experiment_of(folder, 40)
        swept(small, folder / "warm")  # compiles or loads the kernel
        experiment = experiment_of(folder, arguments.records)
        total, kernel = swept(experiment, folder / "out")
        reading, _ = seconds_of(lambda: read_study(read_results(folder / "out")))
        again, _ = seconds_of(lambda: run_sweep(experiment, folder / "out", InProcessEngine()))
    record = {
        "records": arguments.records,
        "sweep_s": total,
        "kernel_s": kernel,
        "sweep_over_kernel": total / kernel,
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
        "read_back_s": reading,
        "sweep_with_nothing_missing_s": again,
        "planned": arguments.planned,
        "expand_s": expanding,
        "plan_s": planning,
    }
    print(json.dumps(record, indent=2))


if __name__ == "__main__":
    main()
