"""``hydrofdi sweep``: from its plan to its experiment file, and its progress: a line on a terminal and in a
notebook, a line now and then elsewhere."""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from shutil import get_terminal_size
from typing import Literal

from hydrofdi import errors
from hydrofdi.config import ExperimentConfig, RunTable, expand_runs
from hydrofdi.config.runs import run_identities
from hydrofdi.engine import Engine, TaskFailure
from hydrofdi.execution.compute import Job, Recorder, run_jobs
from hydrofdi.execution.plan import WHOLE, SweepPart, SweepPlan, plan_sweep
from hydrofdi.indicators.faults import tells_fault
from hydrofdi.settings.arguments import refusal
from hydrofdi.settings.messages import counted, time_text
from hydrofdi.simulation.calibration import leakage_coefficients, unsolved_conditions
from hydrofdi.store.experiment_file import computed_variables, is_current, read_texts, write_experiment
from hydrofdi.store.files import remove_leftovers, require_replaceable
from hydrofdi.store.folder import (
    REQUEST_FILE,
    add_provenance,
    environment_record,
    experiment_lock,
    forget_failure,
    now,
    read_calibrations,
    read_failures,
    read_request,
    require_same_experiment,
    require_unlocked,
    write_calibrations,
    write_request,
)
from hydrofdi.store.names import MISSING, OBSTACLE, STATUS, VERDICT
from hydrofdi.store.results import experiment_file, library_versions
from hydrofdi.store.shards import ShardResults, read_index
from hydrofdi.store.verdicts import doubt_counts, remedy_lines
from hydrofdi.tables.answer import Answer, Piece

_SECONDS_BETWEEN_DRAWINGS, _SECONDS_BETWEEN_LINES = 0.5, 30.0
_BAR = 20

RUNS, COEFFICIENTS = "runs", "leakage coefficients K_i solved before the runs"


class Watching:
    """Progress and messages of a sweep on standard error, if they are shown, from the first second on."""

    def __init__(self, *, is_shown: bool = False) -> None:
        self._is_shown = is_shown
        self._redraws = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._what, self._total, self._done, self._n_failed, self._start = "", 0, 0, 0, time.monotonic()
        self._n_drawn = 0
        self.ended = threading.Event()
        self._lock = threading.RLock()

    def __str__(self) -> str:
        seconds = time.monotonic() - self._start
        counted = f"{self._done:,} of {self._total:,} {self._what}"
        if not self._done:
            return f"{counted}, {time_text(seconds)} so far"
        rate, left = self._done / max(seconds, 1e-9), (self._total - self._done) * seconds / self._done
        speed = f"{rate:,.0f}/s" if rate >= 9.5 else f"{rate:.2g}/s"
        return f"{counted}, {speed}, {self._n_failed:,} failed, {time_text(left)} left"

    def begin(self, what: str, total: int) -> None:
        """State the number of `what` that are to be computed."""
        self._what, self._total, self._done, self._n_failed = what, total, 0, 0
        self._start = time.monotonic()
        self._draw()

    def advance(self, count: int, n_failed: int = 0) -> None:
        """Count more that ended, and how many of these failed."""
        self._done, self._n_failed = self._done + count, self._n_failed + n_failed
        self._draw()

    def tell(self, message: object) -> None:
        """Print a line above the progress."""
        if self._is_shown:
            with self._lock:
                self.erase()
                print(message, file=sys.stderr, flush=True)

    def repeat(self) -> None:
        """Refresh the progress regularly, so that a long run does not look like a standstill."""
        while not self.ended.wait(_SECONDS_BETWEEN_DRAWINGS if self._redraws else _SECONDS_BETWEEN_LINES):
            if self._total:
                self._draw() if self._redraws else self.tell(self)

    def _draw(self) -> None:
        if not (self._is_shown and self._redraws):
            return
        filled = _BAR * self._done // max(self._total, 1)
        line = f"[{'#' * filled}{'.' * (_BAR - filled)}] {self}"[: get_terminal_size().columns - 1]
        with self._lock:
            if not self.ended.is_set():
                sys.stderr.write("\r" + line.ljust(self._n_drawn))
                sys.stderr.flush()
                self._n_drawn = len(line)

    def erase(self) -> None:
        """Remove the progress line."""
        with self._lock:
            if self._n_drawn:
                sys.stderr.write("\r" + " " * self._n_drawn + "\r")
                sys.stderr.flush()
                self._n_drawn = 0


@contextmanager
def watching(progress: bool) -> Iterator[Watching]:
    """The watcher that a caller chose."""
    if not isinstance(progress, bool):
        raise refusal("progress", "True or False", progress)
    watcher = Watching(is_shown=progress)
    if progress:
        threading.Thread(target=watcher.repeat, daemon=True).start()
    try:
        yield watcher
    finally:
        watcher.ended.set()
        watcher.erase()


def run_sweep(
    experiment: ExperimentConfig,
    directory: Path,
    engine: Engine,
    watcher: Watching | None = None,
    *,
    retry_failed: bool = False,
    part: SweepPart = WHOLE,
) -> SweepSummary:
    """Compute the missing runs of an experiment and build its experiment file; a part builds none."""
    start = time.perf_counter()
    watcher = watcher or Watching()
    require_unlocked(directory, shared=bool(part.suffix))
    require_same_experiment(directory, experiment)
    if not (directory / REQUEST_FILE).exists():
        require_replaceable(experiment_file(directory, experiment))
    watcher.tell(f"planning {experiment.name}")
    plan = plan_sweep(experiment, directory, retry_failed=retry_failed, part=part)
    for warning in plan.doubts:
        watcher.tell(f"warning: {warning}")
    if not plan.missing and (part.suffix or is_current(plan.file, experiment)):
        _clear_away(plan)
        return _summary(plan, 0, start)
    recorder = Recorder(directory, part.suffix, watcher.advance)
    try:
        with engine if plan.missing else nullcontext():
            if plan.missing:
                of, workers = counted(len(plan.positions), "run"), counted(engine.workers, "worker")
                watcher.tell(f"{len(plan.missing):,} of {of} to compute with {workers}")
            known = read_calibrations(directory)
            jobs, lost = _jobs(plan, engine, known, watcher)
            with experiment_lock(directory, watcher.tell, part.suffix):
                record = environment_record(experiment)
                _prepare(plan, known, watcher)
                with errors.interruption(
                    lambda: _finish_early(engine, watcher), [signal.SIGTERM]
                ) as requests:
                    _run(plan, engine, jobs, lost, watcher, recorder)
                done = {"ended": now(), "computed": recorder.completed, "costs": recorder.costs}
                add_provenance(directory, record | done, part.suffix)
                if not part.suffix:
                    _write_file(experiment, directory, plan.table, plan.run_ids, recorder.shards)
                summary = _summary(plan, recorder.completed, start)
                for label, message in summary.faults.items():
                    recorder.log("faulty indicator", label=label, message=message)
    except (Exception, KeyboardInterrupt) as error:
        if errors.is_interruption(error):
            stored, planned = _stored(plan)
            completed = recorder.completed
            raise errors.SweepInterrupted(completed, stored + completed, planned) from None
        if isinstance(error, errors.StoreError):
            _clear_away(plan)
        raise
    return replace(summary, interrupted=bool(requests), lost_workers=engine.lost_workers)


def collected(directory: Path) -> None:
    """Build the experiment file of a folder from what is stored there."""
    experiment = read_request(directory)
    table = expand_runs(experiment)
    with experiment_lock(directory, lambda _: None):
        remove_leftovers(directory)
        _write_file(experiment, directory, table, run_identities(table.runs))


def _write_file(
    experiment: ExperimentConfig,
    directory: Path,
    table: RunTable,
    run_ids: Sequence[str],
    fresh: frozenset[str] = frozenset(),
) -> None:
    index = read_index(directory, fresh=fresh)
    results = ShardResults(run_ids, index, read_failures(directory))
    write_experiment(experiment_file(directory, experiment), experiment, table, results, library_versions())
    index.save()


def _jobs(
    plan: SweepPlan, engine: Engine, known: dict[str, float], watcher: Watching
) -> tuple[list[Job], list[tuple[Job, TaskFailure]]]:
    """Jobs of the missing runs, and those that failed while K_i was solved."""
    runs, failures = plan.table.runs.at(plan.simulated), dict[int, TaskFailure]()
    if n_unsolved := unsolved_conditions(runs, known):
        watcher.begin(COEFFICIENTS, n_unsolved)
    required: Literal["any", "none"] = "none" if _may_lack_leaks(plan) else "any"
    try:
        solved = leakage_coefficients(
            runs, engine, known, required=required, on_solved=watcher.advance, lost=failures,
            time_per_job=plan.experiment.limits.time_per_job,
        )  # fmt: skip
    except (KeyboardInterrupt, errors.HydrofdiError) as error:
        kept = {identity: value for identity, value in known.items() if not math.isnan(value)}
        if kept and not isinstance(error, errors.ConfigError):
            write_calibrations(plan.directory, kept)
            watcher.tell(f"kept {len(kept):,} solved leakage coefficients for the next time")
        raise
    coefficients = dict(zip(plan.simulated, solved, strict=True))
    jobs = {}
    for position in plan.missing:  # a stored record brings its own coefficient
        own = plan.run_ids[position], coefficients.get(position, math.nan), plan.record_ids[position]
        job = Job.of(plan.table.runs[position], *own)
        jobs[position] = replace(job, stored=plan.measurable.get(position))
    lost = [(jobs.pop(plan.simulated[k]), failure) for k, failure in failures.items()]
    return list(jobs.values()), lost


def _may_lack_leaks(plan: SweepPlan) -> bool:
    """Whether a sweep makes sense even if none of its missing leaks is possible."""
    others = sorted(set(range(len(plan.run_ids))) - set(plan.missing) | plan.measurable.keys())
    return plan.experiment.has_scenarios or any(
        run.calibration or run.parameters.leakage.internal_coefficient for run in plan.table.runs.at(others)
    )


def _prepare(plan: SweepPlan, calibrations: dict[str, float], watcher: Watching) -> None:
    """Clear away what earlier sweeps left unusable; a part does not. Keep what this sweep asks for."""
    if not plan.part.suffix:
        for shard in plan.index.damaged:
            shard.unlink(missing_ok=True)
            watcher.tell(f"removed the damaged shard {shard.name}; its runs are computed again")
        remove_leftovers(plan.directory)
    retried = {plan.run_ids[position] for position in plan.missing}
    for run_id in retried & read_failures(plan.directory).keys():
        forget_failure(plan.directory, run_id)
    write_request(plan.directory, plan.experiment)
    if calibrations:
        write_calibrations(plan.directory, calibrations)


def _clear_away(plan: SweepPlan) -> None:
    """Remove what ended workers left half written, unless another sweep or part may be at work."""
    if plan.directory.is_dir() and not plan.part.suffix:
        with suppress(errors.StoreError), experiment_lock(plan.directory, lambda _: None):
            remove_leftovers(plan.directory)


def _finish_early(engine: Engine, watcher: Watching) -> None:
    engine.cancel()
    watcher.tell("finishing the runs in progress and storing them; press Ctrl-C again to stop at once")


def _run(
    plan: SweepPlan,
    engine: Engine,
    jobs: list[Job],
    lost: list[tuple[Job, TaskFailure]],
    watcher: Watching,
    recorder: Recorder,
) -> None:
    """Record the jobs that are lost, and run the others."""
    experiment, n_missing = plan.experiment, len(jobs) + len(lost)
    recorder.log("begin", planned=len(plan.positions), missing=n_missing)
    watcher.begin(RUNS, n_missing)
    try:
        for failed in lost:
            recorder.failed(*failed)
        run_jobs(engine, jobs, plan.directory, experiment.store, experiment.limits.time_per_job, recorder)
    except errors.HydrofdiError as error:
        index, failures = read_index(plan.directory, check=False), read_failures(plan.directory)
        so_far = _stored(replace(plan, index=index, failures=failures))
        raise type(error)(f"{error}; {errors.stored_so_far(*so_far)}") from None
    recorder.log("end", completed=recorder.completed, lost_workers=engine.lost_workers)


def _stored(plan: SweepPlan) -> tuple[int, int]:
    return len(plan.positions) - len(plan.missing), len(plan.positions)


def _summary(plan: SweepPlan, completed: int, start: float) -> SweepSummary:
    texts = _texts(plan)
    statuses = Counter(texts[STATUS])
    return SweepSummary(
        planned=len(plan.positions),
        completed=completed,
        measured=min(completed, len(plan.measurable)),
        skipped=len(plan.positions) - len(plan.missing),
        failed=sum(count for status, count in statuses.items() if status not in ("ok", MISSING)),
        seconds=time.perf_counter() - start,
        file=plan.file,
        faults=_faults(texts),
        statuses={status: count for status, count in statuses.items() if status != "ok"},
        verdicts=doubt_counts(texts.get(VERDICT, [])),
        warnings=tuple(plan.warnings),
    )


def _texts(plan: SweepPlan) -> dict[str, list[str]]:
    """Statuses, verdicts and obstacles of the runs: of a sweep from its file, of a part from the shards."""
    if not plan.part.suffix:
        return {k: v for name in (STATUS, VERDICT, OBSTACLE) for k, v in read_texts(plan.file, name).items()}
    run_ids = [plan.run_ids[position] for position in plan.positions]
    index, failures = read_index(plan.directory, check=False), read_failures(plan.directory)
    texts = [variable for variable in computed_variables(plan.table) if variable.is_text]
    columns = ShardResults(run_ids, index, failures).columns(texts, {})
    return {name: values.tolist() for name, values in columns.items()}


def _faults(texts: dict[str, list[str]]) -> dict[str, str]:
    """Label → the most frequent fault of an indicator, with how many runs have one."""
    faults = {}
    for name, obstacles in texts.items():
        sentences = [obstacle for obstacle in obstacles if tells_fault(obstacle)]
        if sentences and name.endswith(OBSTACLE):
            ((sentence, _),) = Counter(sentences).most_common(1)
            faults[name.removesuffix(OBSTACLE)] = (
                f"{sentence}, in {len(sentences)} of {counted(len(obstacles), 'run')}"
            )
    return faults


@dataclass(frozen=True, repr=False)
class SweepSummary(Answer):
    """What a sweep did. True if no run failed.

    Runs ``planned``; ``completed`` now, those of them ``measured`` from stored signals; ``skipped``, as
    stored or failed before; ``failed``, without a good end. ``seconds``: wall time [s]. ``interrupted``:
    whether it was asked to finish early. ``faults``: label → what is wrong with an indicator that failed, in
    how many runs. ``statuses``, ``verdicts``: how runs ended, and words on those that ended well → number,
    ``ok`` left out. ``lost_workers``: processes of the local pool that were killed and replaced.
    """

    planned: int
    completed: int
    measured: int
    skipped: int
    failed: int
    seconds: float
    file: Path
    interrupted: bool = False
    faults: dict[str, str] = field(default_factory=dict)
    statuses: dict[str, int] = field(default_factory=dict)
    verdicts: dict[str, int] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    lost_workers: int = 0

    @property
    def stored(self) -> int:
        """Runs that are stored now, failed ones among them."""
        return self.planned - self.statuses.get(MISSING, 0)

    def __bool__(self) -> bool:
        return not (self.failed or self.faults)

    def parts(self) -> tuple[Piece, ...]:
        """Nothing: all that it says is about the work, not a result."""
        return ()

    def asides(self) -> Iterator[str]:
        """Numbers of runs, the verdicts on them, and what failed."""
        measured = f" ({self.measured:,} from stored signals)" if self.measured else ""
        lost = f", {counted(self.lost_workers, 'worker')} lost and replaced" * bool(self.lost_workers)
        yield (
            f"{counted(self.planned, 'run')}: {self.completed:,} computed{measured}, {self.skipped:,} stored"
            f" before, {self.failed:,} failed, in {time_text(self.seconds)}{lost}"
        )
        yield from remedy_lines(self.verdicts | self.statuses)
        yield from (f"{label}: {fault}" for label, fault in self.faults.items())
