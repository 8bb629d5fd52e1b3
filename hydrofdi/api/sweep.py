"""``hydrofdi sweep``: from its plan to its experiment file."""

from __future__ import annotations

import math
import signal
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Unpack

from hydrofdi import errors, execution
from hydrofdi.api.arguments import count_of, path_of
from hydrofdi.api.plan import WHOLE, Part, SweepPlan, part_of, plan_sweep
from hydrofdi.api.progress import COEFFICIENTS, RUNS, Watching, watching
from hydrofdi.api.results import Results, SweepSummary
from hydrofdi.api.stored import experiment_directory, experiment_file, library_versions, read_results
from hydrofdi.config import ExperimentConfig, RunTable, expand_runs
from hydrofdi.config.loading import Experiment, load_experiment
from hydrofdi.config.runs import run_identities
from hydrofdi.config.shown_values import shown_in
from hydrofdi.engine import TaskFailure
from hydrofdi.indicators.faults import tells_fault
from hydrofdi.quality.doubts import doubt_counts
from hydrofdi.settings.messages import counted
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
from hydrofdi.store.shards import ShardResults, read_index

if TYPE_CHECKING:
    from hydrofdi.api.settings import Settings


def sweep(
    experiment: Experiment | None = None,
    /,
    *,
    out: str | PathLike[str] | None = None,
    workers: int | None = None,
    engine: Literal["local", "in-process", "dask"] = "local",
    scheduler: str | None = None,
    shared_directory: bool = True,
    part: str | None = None,
    retry_failed: bool = False,
    progress: bool = False,
    **settings: Unpack[Settings],
) -> Results:
    """Run whatever is missing and store it, as ``hydrofdi sweep`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        YAML file, or what would stand in one; without it, the nominal actuator with the settings.
    out : path, optional
        Folder of the results; ``results/<name>`` where it is left out.
    workers : int, optional
        Processes; the cores that hydrofdi may use where it is left out.
    engine : {"local", "in-process", "dask"}
        Where runs are computed: in worker processes, in this process, or on a Dask cluster.
    scheduler : str, optional
        Address of the Dask scheduler, such as tcp://host:8786.
    shared_directory : bool
        Dask workers write into the results folder (the default), or send their results.
    part : str, optional
        Only this part of the runs, such as 3/64; ``hydrofdi collect`` joins the parts of all machines.
    retry_failed : bool
        Retry runs that raised an error, hung or lost their worker.
    progress : bool
        Show warnings and progress on standard error.
    **settings
        As in `hydrofdi.simulate`; also what varies: ``grid={"EBM": ["551 MPa", "689 MPa"]}``.

    Raises
    ------
    ConfigError
        With every mistake; nothing is written then.
    StoreError
        The folder is in use, or cannot be written.
    HydrofdiError
        The Dask cluster has ended; the same call continues from what is stored.
    KeyboardInterrupt
        Ctrl-C: a `SweepInterrupted`, after what ran is stored; the same call continues from there.

    Examples
    --------
    >>> import hydrofdi
    >>> grid = {"EBM": ["551 MPa", "689 MPa"]}
    >>> results = hydrofdi.sweep(name="stiffness", duration="2 s", grid=grid, engine="in-process")
    >>> results
    2 runs in results/stiffness: 2 ok; 1 warning, see .warnings
    >>> results.dataset.chamber_1_pressure.sizes["run"]
    2
    >>> results.statuses
    {'ok': 2}
    """
    with watching(progress) as watcher:
        loaded = load_experiment({} if experiment is None else experiment, settings)
        n_worker = None if workers is None else count_of("workers", workers)
        directory = experiment_directory(loaded, None if out is None else path_of(out))
        own = WHOLE if part is None else part_of(part)
        chosen = execution.engine_named(engine, n_worker, scheduler, shared_directory=shared_directory)
        with shown_in(loaded.units):
            summary = run_sweep(loaded, directory, chosen, watcher, retry_failed=retry_failed, part=own)
    if summary.interrupted:
        raise errors.SweepInterrupted(summary.completed, summary.stored, summary.planned, summary)
    return Results(read_results(directory) if own == WHOLE else directory, summary)


def run_sweep(
    experiment: ExperimentConfig,
    directory: Path,
    engine: execution.Engine,
    watcher: Watching | None = None,
    *,
    retry_failed: bool = False,
    part: Part = WHOLE,
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
    recorder = execution.Recorder(directory, part.suffix, watcher.advance)
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


def collect(folder: str | PathLike[str] | Results) -> Results:
    """Build the experiment file from what is stored; runs without a result are holes with a reason.

    Raises
    ------
    StoreError
        The folder contains no experiment, a sweep is at work there, or the file cannot be written.

    Examples
    --------
    >>> import hydrofdi
    >>> study = {"name": "asked", "record": {"duration": "2 s"}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.collect(results.folder)
    1 run in results/asked: 1 ok
    """
    directory = path_of(folder)
    experiment = read_request(directory)
    table = expand_runs(experiment)
    with experiment_lock(directory, lambda _: None):
        remove_leftovers(directory)
        _write_file(experiment, directory, table, run_identities(table.runs))
    return Results(read_results(directory))


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
    plan: SweepPlan, engine: execution.Engine, known: dict[str, float], watcher: Watching
) -> tuple[list[execution.Job], list[tuple[execution.Job, TaskFailure]]]:
    """Jobs of the missing runs, and those that failed while K_i was solved."""
    runs, failures = plan.table.runs.at(plan.simulated), dict[int, TaskFailure]()
    if n_unsolved := execution.unsolved_conditions(runs, known):
        watcher.begin(COEFFICIENTS, n_unsolved)
    required: Literal["any", "none"] = "none" if _may_lack_leaks(plan) else "any"
    try:
        solved = execution.leakage_coefficients(
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
        job = execution.Job.of(plan.table.runs[position], *own)
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


def _finish_early(engine: execution.Engine, watcher: Watching) -> None:
    engine.cancel()
    watcher.tell("finishing the runs in progress and storing them; press Ctrl-C again to stop at once")


def _run(
    plan: SweepPlan,
    engine: execution.Engine,
    jobs: list[execution.Job],
    lost: list[tuple[execution.Job, TaskFailure]],
    watcher: Watching,
    recorder: execution.Recorder,
) -> None:
    """Record the jobs that are lost, and run the others."""
    experiment, n_missing = plan.experiment, len(jobs) + len(lost)
    recorder.log("begin", planned=len(plan.positions), missing=n_missing)
    watcher.begin(RUNS, n_missing)
    try:
        for failed in lost:
            recorder.failed(*failed)
        execution.run_jobs(
            engine, jobs, plan.directory, experiment.store, experiment.limits.time_per_job, recorder
        )
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
        found = [obstacle for obstacle in obstacles if tells_fault(obstacle)]
        if found and name.endswith(OBSTACLE):
            ((sentence, _),) = Counter(found).most_common(1)
            faults[name.removesuffix(OBSTACLE)] = (
                f"{sentence}, in {len(found)} of {counted(len(obstacles), 'run')}"
            )
    return faults
