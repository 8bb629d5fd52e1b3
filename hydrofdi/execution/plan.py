"""``hydrofdi plan``: what a sweep will do, said before it does it."""

from __future__ import annotations

import re
import shutil
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any, NamedTuple
from warnings import catch_warnings

from numpy import bincount

from hydrofdi.config import ExperimentConfig, RunTable, expand_runs
from hydrofdi.config.drive import without_contents
from hydrofdi.config.runs import PHYSICS_VERSION, identities_of_analyses, record_identities, run_identity
from hydrofdi.config.values import ParameterAnswer
from hydrofdi.engine import available_cores
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.arguments import refusal
from hydrofdi.settings.messages import counted, shown_bytes, time_text
from hydrofdi.simulation.lanes import WIDTH
from hydrofdi.store.experiment_file import computed_variables
from hydrofdi.store.folder import Failure, read_failures
from hydrofdi.store.names import dimensions, stored_signals
from hydrofdi.store.results import experiment_file
from hydrofdi.store.shards import ShardIndex, StoredRun, holds_enough, read_index
from hydrofdi.tables.answer import Piece
from hydrofdi.tables.table import Table

_MOST_FACTOR, _START_SECONDS = 2.0, 10.0
"""On a busy machine ready configurations took at most so many times their arithmetic, and the start [s]."""
_CALIBRATION_ROUNDS = 5
"""Simulations that a calibration takes, about."""


class SweepPart(NamedTuple):
    """A share of a sweep: every so many blocks of its runs, whatever is stored."""

    number: int = 1
    of: int = 1

    @property
    def suffix(self) -> str:
        """What the names of its own files end in; empty for the whole."""
        return f"-{self.number}-of-{self.of}" if self.of > 1 else ""

    def positions(self, n_run: int) -> list[int]:
        """Positions of its runs among all."""
        return [k for k in range(n_run) if k // WIDTH % self.of == self.number - 1]


WHOLE = SweepPart()


def part_of(given: Any) -> SweepPart:
    """A part such as ``3/64``."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", given) if isinstance(given, str) else None
    part = SweepPart(*map(int, found.groups())) if found else SweepPart(0)
    if not 1 <= part.number <= part.of:
        raise refusal("part", "a number of so many, from 1 on, such as '3/64'", given)
    return part


@dataclass(frozen=True)
class SweepPlan:
    """What a sweep will do: the runs of its table in their order, their identities and those of their
    records, what is stored, runs that failed before without a result, by identity, and the part to do.
    """

    experiment: ExperimentConfig
    directory: Path
    table: RunTable
    run_ids: tuple[str, ...]
    record_ids: tuple[str, ...]
    index: ShardIndex
    failures: dict[str, Failure]
    part: SweepPart = WHOLE

    @property
    def file(self) -> Path:
        """The experiment file."""
        return experiment_file(self.directory, self.experiment)

    @cached_property
    def positions(self) -> list[int]:
        """Positions of the runs of the part."""
        return self.part.positions(len(self.run_ids))

    @cached_property
    def missing(self) -> list[int]:
        """Positions of the runs that are neither stored with all that is asked for nor known to fail."""
        store = self.experiment.store
        return [
            position
            for position in self.positions
            if (run_id := self.run_ids[position]) not in self.failures
            and not (
                (stored := self.index.runs.get(run_id))
                and holds_enough(self.index.signals_of(stored), store.signals, store.dtype)
            )
        ]

    @cached_property
    def measurable(self) -> dict[int, StoredRun]:
        """Positions of missing runs that need no simulation → where their records are stored."""
        records = ((position, self.index.records.get(self.record_ids[position])) for position in self.missing)
        return {
            position: record
            for position, record in records
            if record is not None and not self._obstacle(record)
        }

    @cached_property
    def simulated(self) -> list[int]:
        """Positions of the missing runs whose records are to be simulated."""
        return [position for position in self.missing if position not in self.measurable]

    @property
    def n_simulated(self) -> int:
        """Number of records that are to be simulated; runs that differ only in their analysis share one."""
        return len({self.record_ids[position] for position in self.simulated})

    def _obstacle(self, record: StoredRun) -> str:
        """Why a stored record cannot be measured as it is stored; empty if it can."""
        store = self.experiment.store
        if not holds_enough(record, store.signals, store.dtype):
            return "stored without the signals or the precision that the request needs"
        if record.status != "ok":
            return ""
        if lacking := sorted(self._needed_signals - stored_signals(record.signals)):
            return f"no stored signals of {', '.join(lacking)}"
        if record.dtype != "float64":
            return "stored signals in single precision, which would give different results"
        return ""

    @cached_property
    def _needed_signals(self) -> set[str]:
        from hydrofdi.execution.compute import needed_signals

        return needed_signals(self.experiment.indicator_choice.made(self.experiment.wavelet))

    @cached_property
    def file_bytes(self) -> int:
        """Size of the experiment file before compression; the shards take as much again."""
        store, sizes = self.experiment.store, dimensions(self.table.runs)
        n_sample = self.table.runs[0].parameters.record.n_sample
        n_number = sum(
            prod(sizes[name] for name in variable.dimensions[1:])
            for variable in computed_variables(self.table)
        )
        n_signal = len(stored_signals(store.signals) - self.experiment.absent_signals)
        n_byte = (4 if store.dtype == "float32" else 8) * n_sample * n_signal
        return len(self.run_ids) * (8 * n_number + n_byte)

    @property
    def free_bytes(self) -> int:
        """Free space at their place."""
        folder = next(path for path in (self.directory, *self.directory.resolve().parents) if path.exists())
        return shutil.disk_usage(folder).free

    @cached_property
    def doubts(self) -> list[str]:
        """What is most likely a mistake; a sweep says it, too."""
        from hydrofdi.execution.checks import likely_mistakes

        doubts = likely_mistakes(self.experiment, self.table.runs.distinct)
        needed, free = 2 * self.file_bytes, self.free_bytes
        if needed > free:
            sizes = f"needs {shown_bytes(needed)}, of which {shown_bytes(free)} are free"
            doubts.append(f"{sizes}; 'store: {{signals: none}}' keeps only the features")
        return doubts + [f"damaged: {text}" for text in self.index.damaged.values()]

    @cached_property
    def warnings(self) -> list[str]:
        """What deserves a second look before the sweep starts, each said once."""
        from hydrofdi.execution.checks import experiment_warnings

        said = experiment_warnings(self.experiment, self.table.runs.distinct)
        return list(dict.fromkeys([*self.doubts, *said]))

    def reason(self, position: int) -> str:
        """Why a missing run is to be computed."""
        run_id = self.run_ids[position]
        if run_id in self.index.runs:
            return self._obstacle(self.index.signals_of(self.index.runs[run_id]))
        if run_id in self.index.lost:
            return "its shard is damaged"
        if (record := self.index.records.get(self.record_ids[position])) is not None:
            obstacle = self._obstacle(record)
            how = f"simulated again ({obstacle})" if obstacle else "measured from its stored signals"
            return f"another analysis of a stored record, {how}"
        for version in sorted(self.index.physics_versions - {PHYSICS_VERSION}):
            if run_identity(self.table.runs[position], version) in self.index.runs:
                return f"physics version changed from {version} to {PHYSICS_VERSION}"
        return "new"


def plan_sweep(
    experiment: ExperimentConfig,
    directory: Path,
    *,
    retry_failed: bool = False,
    run_ids: tuple[str, ...] | None = None,
    part: SweepPart = WHOLE,
) -> SweepPlan:
    """The runs of an experiment, and which of them are stored. Writes nothing."""
    table = expand_runs(experiment)
    records = [run.record for run in table.runs.distinct("record")]
    time_grids = {(record.n_sample, record.sampling_frequency) for record in records}
    if experiment.store.signals != "none" and len(time_grids) > 1:
        message = (
            "signals with different durations or sampling frequencies cannot be stored in one data set;"
            " set store: {signals: none}"
        )
        raise ConfigError([Issue(message, "store.signals")])
    record_ids = record_identities(table.runs)
    run_ids = run_ids or identities_of_analyses(table.runs, record_ids)
    failures = {} if retry_failed else read_failures(directory)
    index = read_index(directory, check=part == WHOLE)  # parts are many: what one stores, not each checks
    return SweepPlan(experiment, directory, table, run_ids, record_ids, index, failures, part)


_PART = 0.2
"""Part of a record that is simulated for a prediction."""


def predict_seconds(plan: SweepPlan, workers: int) -> tuple[float, float]:
    """Least and most wall time to expect of a plan [s].

    The beginning of a few of its runs is simulated without their leakage. The least is the time of the
    arithmetic; workers that start, storing, and a busy machine add to it.
    """
    runs = plan.table.runs.at(plan.simulated)
    if not runs:
        return 0.0, 0.0
    from hydrofdi.execution.compute import Job, batch_shape, compute_columns

    jobs = [
        Job.of(run, "", run.parameters.leakage.internal_coefficient or 0.0) for run in islice(runs, 4 * WIDTH)
    ]
    whole = [job for job in jobs if batch_shape(job) == batch_shape(jobs[0])][:WIDTH]
    for part in (_PART, 1.0):
        # A part of a record may be too short for its analysis.
        with catch_warnings(action="error", category=RuntimeWarning), suppress(ValueError, RuntimeWarning):
            short = {"record.duration": part * whole[0].parameters.record.duration}
            jobs = [replace(job, parameters=job.parameters.with_values(short)) for job in whole]
            compute_columns(jobs)  # compiles, or loads their kernels
            break
    start = time.perf_counter()
    compute_columns(jobs)
    seconds = (time.perf_counter() - start) / part
    blocks = -(-len(runs) // WIDTH) + _CALIBRATION_ROUNDS * -(-runs.solutions()["total"] // WIDTH)
    least = max(seconds, blocks * seconds * WIDTH / max(len(jobs), WIDTH) / workers)
    return least, _MOST_FACTOR * least + _START_SECONDS


@dataclass(frozen=True, repr=False)
class Plan(ParameterAnswer):
    """What a sweep will do, as `hydrofdi.plan` returns it.

    Runs: ``planned``, all; ``controls_added``, healthy ones to compare with; ``missing``, those to be
    computed, with ``reasons`` → how many. For these, ``simulated_records``, ``measured_analyses`` from
    stored signals, and the ``solutions``: leakage flows, conditions and total of the K_i to solve,
    ``calibrated_at`` each run or the nominal actuator. ``axes``: dotted parameter → its values in SI.
    ``predicted_seconds`` to ``predicted_seconds_most``: wall time to expect [s], from a few runs that were
    tried. The shards take as much as the file. ``units``: dotted parameter → the unit that the experiment is
    written in.
    """

    experiment: str
    file: str
    planned: int
    swept: int
    controls_added: int
    study: dict[str, Any] | None
    axes: dict[str, Any]
    stored: int
    failed_before: int
    missing: int
    simulated_records: int
    measured_analyses: int
    reasons: dict[str, int]
    solutions: dict[str, int]
    calibrated_at: str
    workers: int
    predicted_seconds: float
    predicted_seconds_most: float
    predicted_file_bytes: int
    free_bytes: int
    warnings: list[str]
    units: dict[str, str]

    def parts(self) -> Iterator[Piece]:
        """What it says; records of a study of one kind and purpose have a row."""
        study, added, failed = self.study or {}, self.controls_added, self.failed_before
        reasons = ", ".join(f"{reason} {count:,}" for reason, count in self.reasons.items())
        size, free = map(shown_bytes, (self.predicted_file_bytes, self.free_bytes))
        times = " to ".join(map(time_text, (self.predicted_seconds, self.predicted_seconds_most)))
        yield {
            "experiment": f"{self.experiment} → {self.file}",
            "runs": f"{self.planned:,}" + f", {added:,} of them healthy for comparison" * bool(added),
            "axes": self.axes,
            "designs": study["designs"] if study and len(study["designs"]) > 1 else [],
            "varies": study.get("varies"),
            "per record": ", ".join(study.get("differs_per_record", ())),
            "stored": self.stored,
            "failed": f"{failed:,} before; --retry-failed tries them again" * bool(failed),
            "to compute": f"{self.missing:,}" + (f" ({reasons})" if reasons else ""),
            "to simulate": counted(self.simulated_records, "record"),
            "leakage coefficients": counted(self.solutions["total"], "solution"),
            "predicted": f"{times} with {counted(self.workers, 'worker')}" * bool(self.missing),
            "size": f"{size}, and as much in shards; {free} free",
        }
        if study:
            alike: dict[tuple[str, str], list[dict[str, Any]]] = {}
            for each in study["populations"]:
                alike.setdefault((each["kind"], "fit" if each["is_fit"] else "test"), []).append(each)
            columns = {
                "records of": [kind for kind, _ in alike],
                "to": [purpose for _, purpose in alike],
                "number": [sum(each["records"] for each in own) for own in alike.values()],
                "populations": [", ".join(each["name"] for each in own) for own in alike.values()],
            }
            yield from ("", Table.of(columns), "")
        yield from (f"warning: {warning}" for warning in self.warnings)


def planned(
    experiment: ExperimentConfig, directory: Path, workers: int | None, *, retry_failed: bool = False
) -> Plan:
    """What a sweep of an experiment would do. Writes nothing."""
    workers = workers or available_cores()
    made = plan_sweep(experiment, directory, retry_failed=retry_failed)
    n_run = len(made.run_ids)
    swept = {*experiment.ensemble.names, *experiment.sweep.names}  # not what a study draws
    axes = {k: without_contents([*each]) for k, each in made.table.axes.items() if k in swept}
    least, most = predict_seconds(made, workers)
    failed = sum(run_id in made.failures for run_id in made.run_ids)
    return Plan(
        experiment=experiment.name,
        file=str(made.file),
        planned=n_run,
        swept=made.table.n_swept,
        controls_added=n_run - made.table.n_swept,
        study=_study_record(made),
        axes=axes,
        stored=n_run - len(made.missing) - failed,
        failed_before=failed,
        missing=len(made.missing),
        simulated_records=made.n_simulated,
        measured_analyses=len(made.measurable),
        reasons=dict(Counter(map(made.reason, made.missing))),
        solutions=made.table.runs.at(made.simulated).solutions(),
        calibrated_at=experiment.calibration.at,
        workers=workers,
        predicted_seconds=least,
        predicted_seconds_most=most,
        predicted_file_bytes=made.file_bytes,
        free_bytes=made.free_bytes,
        warnings=made.warnings,
        units=experiment.units,
    )


def _study_record(plan: SweepPlan) -> dict[str, Any] | None:
    """The populations and designs of a study and what it draws, in SI; None without a study."""
    roles, study = plan.table.study, plan.experiment.study
    if roles is None or study is None:
        return None
    counts = bincount(roles.of_run[roles.design_of_run == 0]).tolist()
    changes = study.shifts | study.confusions
    return {
        "records": len(plan.run_ids) // len(roles.designs),
        "designs": without_contents(list(roles.designs)),
        "populations": [
            {
                "name": each.name,
                "kind": each.kind.value,
                "is_fit": each.is_fit,
                "records": count,
                "sets": changes.get(each.name, {}) if each.kind.value in ("shift", "confusion") else {},
            }
            for each, count in zip(roles.populations, counts, strict=True)
        ],
        "varies": study.population.over,
        "differs_per_record": study.population.per_record,
    }
