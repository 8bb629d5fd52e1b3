"""Speed of hydrofdi, compared with alternatives and with its targets.

Run it with ``make bench``. The table goes to standard error, the same numbers as JSON to standard output.
Contestants take turns, so that other load on the machine affects all of them; medians of the rounds are
shown.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import numpy as np
import plain_loop
import processes
import solvers
from full_lanes import advance_full_lanes
from indicators import measure_indicators, tell_indicators
from jobs import AT_REST, IN_MOTION, Job, d2_rms, lane_jobs
from options import measure_options
from sensors import measure_sensors, tell_sensors

from hydrofdi.engine import available_cores
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.lanes import WIDTH

KERNEL_RECORD = 4.0
"""Duration of the record of the timed kernels [s]."""

SOLVER_RECORD = 2.0
"""Duration of the record of the general solvers and of all errors [s]."""

ERROR_JOBS = (0, 7, 20, 31)
"""Jobs whose d2 is compared; the largest error is reported."""


@dataclass
class Contestant:
    """A way to solve jobs, and its measured times."""

    title: str
    run: Callable[[], object]
    job_steps: int
    pressures: Callable[[list[Job]], list[np.ndarray]]
    times: list[float] = field(default_factory=list)

    def nanoseconds(self, statistic: Callable[[list[float]], float] = np.median) -> float:
        return 1e9 * float(statistic(self.times)) / self.job_steps


@dataclass(frozen=True)
class Target:
    """A measured value and its target."""

    name: str
    measured: float
    relation: str
    target: float
    unit: str

    @property
    def is_met(self) -> bool:
        met = self.measured >= self.target if self.relation == ">=" else self.measured <= self.target
        return bool(met)

    def __str__(self) -> str:
        verdict = "met" if self.is_met else "NOT MET"
        return (
            f"{self.name:58} {self.measured:9.3g} {self.unit:3} {self.relation} {self.target:<5g} {verdict}"
        )


def lane_pressures(jobs: list[Job]) -> list[np.ndarray]:
    return list(simulate_batch([run for run, _ in jobs], [k for _, k in jobs]).chamber_1_pressure)


def one_by_one(solve: Callable[[Job], np.ndarray]) -> Callable[[list[Job]], list[np.ndarray]]:
    return lambda jobs: [solve(job) for job in jobs]


def contestants() -> dict[str, Contestant]:
    short = lane_jobs(SOLVER_RECORD)
    some = lane_jobs(KERNEL_RECORD)[::8]
    steps, short_steps = some[0][0].record.n_step, short[0][0].record.n_step

    def lanes(title: str, jobs: list[Job]) -> Contestant:
        return Contestant(title, lambda: advance_full_lanes(jobs), WIDTH * steps, lane_pressures)

    def solver(title: str, solve: Callable[[Job], np.ndarray]) -> Contestant:
        return Contestant(title, lambda: solve(short[7]), short_steps, one_by_one(solve))

    entrants = {
        "lanes": lanes("lane kernel, one drive", lane_jobs(KERNEL_RECORD)),
        "drives": lanes(f"lane kernel, {WIDTH} drives", lane_jobs(KERNEL_RECORD, drives=WIDTH)),
        "moving": lanes("lane kernel, in motion", lane_jobs(KERNEL_RECORD, values=IN_MOTION)),
        "resting": lanes("lane kernel, at rest", lane_jobs(KERNEL_RECORD, values=AT_REST)),
        "plain": Contestant(
            "plain compiled loop",
            lambda: [plain_loop.pressure(job) for job in some],
            len(some) * steps,
            one_by_one(plain_loop.pressure),
        ),
        "lsoda": solver("SciPy LSODA, rtol 1e-6", solvers.scipy_lsoda),
    }
    if (numbalsoda := solvers.numbalsoda_solver()) is not None:
        entrants["numbalsoda"] = solver("numbalsoda, rtol 1e-6", numbalsoda)
    else:
        tell("numbalsoda is not installed and is skipped")
    return entrants


def take_turns(entrants: list[Contestant], rounds: int) -> None:
    for entrant in entrants:
        entrant.run()
    for _ in range(rounds):
        for entrant in entrants:
            start = time.perf_counter()
            entrant.run()
            entrant.times.append(time.perf_counter() - start)


def d2_errors(entrants: list[Contestant]) -> dict[str, float]:
    """Largest error of the RMS of d2 [Pa] against a plain loop with a hundredth of the step."""
    jobs = [lane_jobs(SOLVER_RECORD)[k] for k in ERROR_JOBS]
    reference = [d2_rms(plain_loop.pressure(job, refinement=100)) for job in jobs]
    return {
        entrant.title: max(
            abs(d2_rms(pressure) - exact)
            for pressure, exact in zip(entrant.pressures(jobs), reference, strict=True)
        )
        for entrant in entrants
    }


def measure_kernels(rounds: int) -> tuple[dict[str, dict[str, float]], list[Target]]:
    named = contestants()
    entrants = list(named.values())
    take_turns(entrants, rounds)
    errors = d2_errors(entrants)
    rows = {
        entrant.title: {
            "ns_per_step_and_job": entrant.nanoseconds(),
            "least_ns_per_step_and_job": entrant.nanoseconds(min),
            "d2_rms_error_Pa": errors[entrant.title],
        }
        for entrant in entrants
    }
    lanes = named["lanes"]
    at_rest = ratio(named["resting"], named["moving"])
    faster = ratio(named["plain"], lanes)
    targets = [
        Target("lane kernel: times faster than the plain loop", faster, ">=", 25, "×"),
        Target("lane kernel: at rest, times in motion", at_rest, "<=", 1.1, "×"),
    ]
    if "numbalsoda" in named:
        faster = ratio(named["numbalsoda"], lanes)
        targets.append(Target("lane kernel: times faster than numbalsoda", faster, ">=", 5, "×"))
    return rows, targets


def judge_options(rounds: int) -> tuple[dict[str, dict[str, float]], list[Target]]:
    rows = measure_options(4 * rounds)
    tell(
        f"\n{'options of the model':26} {'ns per step and job':>20} {'times off':>11} {'to compile [s]':>15}"
    )
    for title, row in rows.items():
        tell(
            f"{title:26} {row['ns_per_step_and_job']:20.2f} {row['times_all_off']:11.2f}"
            f" {row['compilation_seconds']:15.1f}"
        )
    slowest = max(row["compilation_seconds"] for row in rows.values())
    return rows, [
        Target("free air: times all options off", rows["free air"]["times_all_off"], "<=", 3.0, "×"),
        Target("slowest combination of options to compile", slowest, "<=", 2.0, "s"),
    ]


def ratio(slow: Contestant, fast: Contestant) -> float:
    """Median over the rounds of the time ratio of `slow` to `fast` per step and job."""
    quotients = np.array(slow.times) / np.array(fast.times) * (fast.job_steps / slow.job_steps)
    return float(np.median(quotients))


def kernel_rate(core: int | None) -> float:
    """Time per step and job of the kernel on one core while the other cores do the same [s]."""
    pin(core)
    jobs = lane_jobs(KERNEL_RECORD)
    advance_full_lanes(jobs)
    start, rounds = time.perf_counter(), 0
    while time.perf_counter() - start < 2.0:
        advance_full_lanes(jobs)
        rounds += 1
    return (time.perf_counter() - start) / (rounds * WIDTH * jobs[0][0].record.n_step)


def measure_sweep(n_job: int, repetitions: int) -> tuple[dict[str, float], list[Target]]:
    """Measure a sweep between two measurements of the pure kernel on the same cores."""
    cores = own_cores()
    n_step = lane_jobs(20.0)[0][0].record.n_step
    results = []
    with multiprocessing.get_context("spawn").Pool(len(cores)) as pool:
        for _ in range(repetitions):
            before = pool.map(kernel_rate, cores, chunksize=1)
            sweep = processes.large_sweep(n_job, len(cores))
            rate = float(np.mean(before + pool.map(kernel_rate, cores, chunksize=1)))
            sweep["kernel_seconds"] = rate * sweep["jobs"] * n_step / len(cores)
            results.append(sweep)
    best = min(results, key=lambda sweep: sweep["seconds"] / sweep["kernel_seconds"])
    best["cores"], best["repetitions"] = len(cores), repetitions
    quotient = best["seconds"] / best["kernel_seconds"]
    targets = [
        Target(f"{best['jobs']:g} jobs without signals: times the pure kernel", quotient, "<=", 1.4, "×"),
        Target("  peak memory of parent and workers", best["peak_memory"] / 1e9, "<=", 1.5, "GB"),
    ]
    return best, targets


def measure_start_up(rounds: int) -> tuple[dict[str, dict[str, float]], list[Target]]:
    times = processes.start_up(rounds)
    compilation = processes.first_compilation(2)
    times["first compilation"] = {"median": float(np.median(compilation)), "least": min(compilation)}
    numpy_time = times["import numpy"]["median"]
    for time_ in times.values():
        time_["median_per_import_numpy"] = time_["median"] / numpy_time
    targets = [
        Target(f"{name} ({time_['median']:.2f} s)", time_["median_per_import_numpy"], "<=", limit, "× numpy")
        for name, time_ in times.items()
        if (limit := _limit(name)) is not None
    ]
    targets.append(Target("first compilation", times["first compilation"]["median"], "<=", 8.0, "s"))
    return times, targets


def _limit(command: str) -> float | None:
    """Largest time of a command relative to ``import numpy``."""
    if not command.startswith("hydrofdi "):
        return None
    return 5.0 if command.split()[1] in ("simulate", "check", "plan") else 3.5


def own_cores() -> list[int | None]:
    return sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [None] * available_cores()


def pin(core: int | None) -> None:
    if core is not None:
        os.sched_setaffinity(0, {core})


def tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def tell_kernels(rows: dict[str, dict[str, float]]) -> None:
    tell(f"{'per core':26} {'ns per step and job':>20} {'least':>9} {'error of d2 RMS [Pa]':>22}")
    for title, row in rows.items():
        tell(
            f"{title:26} {row['ns_per_step_and_job']:20.2f} {row['least_ns_per_step_and_job']:9.2f}"
            f" {row['d2_rms_error_Pa']:22.2g}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each comparison")
    parser.add_argument("--sweep", type=int, default=10_000, metavar="N", help="jobs of the sweep; 0: none")
    parser.add_argument(
        "--sweeps", type=int, default=2, metavar="N", help="number of sweeps; the fastest counts"
    )
    options = parser.parse_args()
    cores = own_cores()
    tell(f"{platform.machine()}, {len(cores)} cores, Python {platform.python_version()}\n")
    report: dict[str, object] = {"rounds": options.rounds, "cores": len(cores)}
    report["start_up"], targets = measure_start_up(options.rounds)
    if options.sweep:
        report["sweep"], more = measure_sweep(options.sweep, options.sweeps)
        targets += more
    pin(cores[0])
    report["kernels"], more = measure_kernels(options.rounds)
    tell_kernels(report["kernels"])  # type: ignore[arg-type]
    report["options"], still_more = judge_options(options.rounds)
    more += still_more
    report["sensors"] = measure_sensors(options.rounds)
    tell_sensors(report["sensors"])  # type: ignore[arg-type]
    report["indicators"], cheap = measure_indicators(options.rounds, advance_full_lanes)
    tell_indicators(report["indicators"], cheap)  # type: ignore[arg-type]
    more.append(Target("cheap indicators of a record: times the kernel", cheap, "<=", 1.5, "×"))
    tell("\ntarget")
    for target in targets + more:
        tell(str(target))
    report["targets"] = [asdict(target) | {"is_met": target.is_met} for target in targets + more]
    print(json.dumps(report, indent=2))


if __name__ == "__main__":
    main()
