"""Measure the runner: 100,000 runs without signals, and 1,000 runs with all of them.

    make bench-runner

Prints a table and the same as JSON, and writes the JSON to results/bench-runner.json. Nothing is asserted.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

COMMAND = [sys.executable, "-m", "hydrofdi"]
GRID = """\
name: {name}
record: {{duration: {duration} s}}
store: {{signals: {signals}}}
sweep:
  grid:
    leakage.internal_coefficient: {{linspace: [0, 3e-8, {leakages}]}}
    fluid.bulk_modulus: {{linspace: [551 MPa, 827 MPa, {moduli}]}}
"""


def write_grid(folder, name, leakages, moduli, duration, signals):
    file = folder / f"{name}.yaml"
    file.write_text(
        GRID.format(name=name, leakages=leakages, moduli=moduli, duration=duration, signals=signals)
    )
    return file


def timed(*command):
    """Wall time [s], peak memory of the process [MB] and standard output of a command."""
    code = (
        "import resource, subprocess, sys; done = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE);"
        "sys.stdout.buffer.write(done.stdout);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, file=sys.stderr);"
        "sys.exit(done.returncode)"
    )
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, command)], capture_output=True, text=True, check=True
    )
    return time.perf_counter() - start, int(done.stderr.split()[-1]) / 1e3, done.stdout


def pure_seconds(file, out, workers):
    """Kernel and feature time of all runs of a sweep [s], on the same number of cores as the sweep."""
    code = f"from runner import core_seconds; print(core_seconds({str(file)!r}, {str(out)!r}, 24))"
    command = [sys.executable, "-c", code]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    cores = [
        subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True) for _ in range(workers)
    ]
    return sum(float(core.communicate()[0]) for core in cores) / workers**2


def core_seconds(file, out, n_sample_batch):
    """Kernel and feature time of all runs of a sweep on one core [s], extrapolated from some batches."""
    from hydrofdi.config import load_experiment
    from hydrofdi.execution.compute import Job, compute_columns, split_jobs
    from hydrofdi.execution.plan import plan_sweep

    plan = plan_sweep(load_experiment(Path(file)), Path(out))
    jobs = [
        Job(run_id, run.parameters, run.parameters.leakage.internal_coefficient)
        for run_id, run in zip(plan.run_ids, plan.table.runs, strict=True)
    ]
    batches = split_jobs(jobs, 2)
    compute_columns(batches[0])
    chosen = batches[:: max(1, len(batches) // n_sample_batch)]
    start = time.perf_counter()
    for batch in chosen:
        compute_columns(batch)
    return (time.perf_counter() - start) * len(jobs) / sum(map(len, chosen))


def processor_seconds(file, out):
    """Processor time of a sweep in a single process [s]: total, and of kernel and features.

    Other programs affect it less than wall time.
    """
    from hydrofdi.config import load_experiment
    from hydrofdi.engine import InProcessEngine
    from hydrofdi.execution import compute
    from hydrofdi.execution.sweeping import run_sweep

    measured, spent = compute.compute_columns, []

    def watched(jobs):
        start = time.process_time()
        columns = measured(jobs)
        spent.append(time.process_time() - start)
        return columns

    compute.compute_columns = watched
    start = time.process_time()
    run_sweep(load_experiment(file), out, InProcessEngine())
    compute.compute_columns = measured
    return time.process_time() - start, sum(spent)


def reading(file):
    """Time [s] and memory growth [MB] for reading all metrics of an experiment file."""
    code = (
        "import resource, sys, time; from pathlib import Path;"
        " from hydrofdi.store.experiment_file import read_experiment;"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3;"
        "before, start = peak(), time.perf_counter(); data = read_experiment(Path(sys.argv[1]));"
        "print(time.perf_counter() - start, peak() - before, len(data.columns))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(file)], stdout=subprocess.PIPE, text=True, check=True
    )
    seconds, megabytes, n_metric = map(float, done.stdout.split())
    return seconds, megabytes, int(n_metric)


def many_runs(folder, n_axis, workers):
    """A large sweep of short records without signals."""
    file = write_grid(folder, "many", n_axis, n_axis, 2, "none")
    out = folder / "many"
    plan_seconds, _, _ = timed(*COMMAND, "plan", file, "--out", out)
    pure = [pure_seconds(file, folder / "nowhere", workers)]
    seconds, memory, printed = timed(*COMMAND, "sweep", file, "--out", out, "--workers", workers, "--json")
    pure.append(pure_seconds(file, folder / "nowhere", workers))
    n_run = json.loads(printed)["planned"]
    again, _, _ = timed(*COMMAND, "sweep", file, "--out", out, "--workers", workers)
    read, growth, n_metric = reading(out / "many.h5")
    total, kernel = processor_seconds(file, folder / "alone")
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    return {
        "runs": n_run,
        "end_to_end_s": seconds,
        "pure_kernel_and_features_s": sum(pure) / 2,
        "overhead_percent": 100.0 * (2 * seconds / sum(pure) - 1.0),
        "processor_time_s": total,
        "processor_time_beside_kernel_and_features_percent": 100.0 * (total / kernel - 1.0),
        "parent_peak_memory_MB": memory,
        "size_on_disk_MB": size / 1e6,
        "experiment_file_MB": (out / "many.h5").stat().st_size / 1e6,
        "plan_s": plan_seconds,
        "resume_with_nothing_missing_s": again,
        "read_all_metrics_s": read,
        "read_all_metrics_MB": growth,
        "metrics_read": n_metric,
    }


def resume_seconds(folder, workers):
    """Time of a sweep of 10,000 stored runs to find that nothing is missing [s]."""
    file = write_grid(folder, "stored", 100, 100, 2, "none")
    timed(*COMMAND, "sweep", file, "--out", folder / "stored", "--workers", workers)
    return min(timed(*COMMAND, "sweep", file, "--out", folder / "stored")[0] for _ in range(3))


def plain_write_seconds(folder):
    """Time to write the bytes of 1,000 runs with all signals to disk [s]."""
    rows = np.random.default_rng(0).random((1000, 60_000))
    start = time.perf_counter()
    with h5py.File(folder / "plain.h5", "w") as plain:
        plain["signals"] = rows
    with open(folder / "plain.h5", "rb") as file:
        os.fsync(file.fileno())
    seconds = time.perf_counter() - start
    (folder / "plain.h5").unlink()
    return seconds


def stored_signals(folder, workers, compression):
    """1,000 runs with all signals, compared with writing as many bytes with h5py before and after."""
    file = write_grid(folder, f"signals-{compression}", 10, 100, 20, "all")
    out = folder / f"signals-{compression}"
    command = [*COMMAND, "sweep", file, "--out", out, "--workers", workers]
    written = [plain_write_seconds(folder)]
    seconds, memory, _ = timed(*command, "--set", f"store.compression={compression}")
    written.append(plain_write_seconds(folder))
    file_size = next(out.glob("*.h5")).stat().st_size
    shutil.rmtree(out)
    pure = pure_seconds(file, folder / "nowhere", workers)
    return {
        "compression": compression,
        "end_to_end_s": seconds,
        "pure_kernel_and_features_s": pure,
        "h5py_write_of_as_many_bytes_s": sum(written) / 2,
        "ratio": 2 * seconds / sum(written),
        "parent_peak_memory_MB": memory,
        "experiment_file_MB": file_size / 1e6,
    }


def show(title, record):
    print(f"\n{title}")
    for name, value in record.items():
        print(f"  {name:50s} {value:,.2f}" if isinstance(value, float) else f"  {name:50s} {value}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--axis", type=int, default=317, help="values of each of the two axes")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=".") as name:
        folder = Path(name)
        record = {"many_runs": many_runs(folder, arguments.axis, arguments.workers)}
        show(
            "runs of 2 s without signals (targets: overhead < 50 %, reading < 1 s and 200 MB)",
            record["many_runs"],
        )
        record["resume_10000_s"] = resume_seconds(folder, arguments.workers)
        show("10,000 stored runs (target: < 1 s)", {"resume_s": record["resume_10000_s"]})
        record["signals"] = [
            stored_signals(folder, arguments.workers, compression) for compression in ("none", "lzf", "gzip")
        ]
        for entry in record["signals"]:
            show("1,000 runs of 20 s with all signals (target: ratio < 3)", entry)
    Path("results").mkdir(exist_ok=True)
    Path("results/bench-runner.json").write_text(json.dumps(record, indent=2) + "\n")
    print(" wrote results/bench-runner.json")


if __name__ == "__main__":
    main()
