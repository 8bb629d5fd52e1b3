"""Questions to the folder of a sweep: progress, integrity, reasons of a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.config import ExperimentConfig, RunSpec
from hydrofdi.config.loading import Experiment, load_experiment
from hydrofdi.config.request import parameter_names
from hydrofdi.config.runs import NO_ROW, record_identity
from hydrofdi.config.study import StudyTable
from hydrofdi.config.values import ParameterAnswer, shown_options
from hydrofdi.errors import StoreError
from hydrofdi.execution.plan import SweepPlan, plan_sweep
from hydrofdi.settings.arguments import path_of, refusal
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_file import read_texts
from hydrofdi.store.folder import read_provenance, read_request
from hydrofdi.store.names import MESSAGE, MISSING, STATUS, VERDICT, output_variables, stored_variables
from hydrofdi.store.results import rows_named, stored_run_ids
from hydrofdi.store.shards import ShardResults, read_index, read_rows
from hydrofdi.store.verdicts import DOUBTS, REMEDIES, Doubt, doubt_counts, doubts_of, remedy_lines
from hydrofdi.tables.answer import Answer, Piece

Folder = Any
"""Folder of an experiment, or the `hydrofdi.Results` in it."""

_SAID = (MESSAGE, VERDICT, *(doubt.number for doubt in DOUBTS.values()))


@dataclass(frozen=True, repr=False)
class SweepStatus(Answer):
    """How far a sweep is: numbers of runs; failed ones count as done too, unless they left no result.

    `earlier` runs are stored by an earlier version of the physics; reports read them, a sweep does not.
    `verdicts` counts the runs of the experiment file that are not ``ok``, word by word.
    `damaged` says of each shard that cannot be read what is wrong with it; its runs are missing.
    """

    planned: int
    done: int
    failed: int
    missing: int
    statuses: dict[str, int]
    damaged: list[str]
    earlier: int = 0
    verdicts: dict[str, int] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return not (self.failed or self.damaged)

    def parts(self) -> Iterator[Piece]:
        """The numbers, and what is wrong."""
        stored = ((name, n) for name, n in sorted(self.statuses.items()) if name != MISSING)
        details = ", ".join(f"{count:,} {name}" for name, count in stored)
        yield (
            f"{self.planned:,} planned, {self.done:,} done, {self.failed:,} failed,"
            f" {self.missing:,} missing{f' ({details})' if details else ''}"
        )
        yield from remedy_lines(self.verdicts)
        if self.earlier:
            runs = counted(self.earlier, "run")
            yield f"stored by an earlier version of the physics: {runs}; a sweep computes them again"
        yield from (f"{fault}; the next sweep computes its runs again" for fault in self.damaged)


@dataclass(frozen=True, repr=False)
class Explanation(ParameterAnswer):
    """Why a run is as it is.

    ``reason`` to compute it: what of its request is not stored, its record or its analysis; empty where it is
    stored. ``causes``: the step limits that a diverged run exceeds. ``position``: row in the experiment file;
    ``role``: population of a run of a study, and whether thresholds are fitted to its record or tested on it.
    ``request``: all that determines the run, in SI; ``differences``: dotted parameter → (value of the fixed
    baseline, or of the nominal run without one, value of the run), in SI; ``is_baseline``: whether it is this
    baseline. ``analysis``: label of an indicator → its ``analysis_id``, its ``options`` that differ from the
    defaults, in SI, and these in readable units (``shown``). ``calibration``: conditions under which its K_i
    was solved. ``shard``: where it is stored, or empty; ``provenance``: the latest sweep on the folder.
    ``verdict``: how far it can be believed, empty if it is not stored; ``doubts``: word of it → the number
    behind it, what it means, and what to do; ``remedy`` of a failure. ``units``: dotted parameter →
    the unit that the experiment is written in.
    """

    run_id: str
    record_id: str
    reason: str
    status: str
    message: str
    log: str
    causes: list[str]
    position: int
    role: dict[str, Any] | str | None
    request: dict[str, dict[str, Any]]
    differences: dict[str, tuple[Any, Any]]
    analysis: dict[str, dict[str, Any]]
    calibration: dict[str, dict[str, Any]] | None
    shard: str
    provenance: dict[str, Any] | None
    verdict: str
    doubts: dict[str, dict[str, Any]]
    remedy: str
    is_baseline: bool
    units: dict[str, str]

    def parts(self) -> Iterator[Piece]:
        """What is known of the run, without its whole request."""
        facts = dict(vars(self))
        for name in ("request", "calibration", "units", "log", "provenance"):
            del facts[name]
        facts["analysis"] = {
            label: f"{each['analysis_id']}: {each['shown'] or 'default options'}"
            for label, each in self.analysis.items()
        }
        if self.provenance:
            facts |= {name: self.provenance[name] for name in ("started", "python")}
            git = self.provenance["git"] or {}
            facts["commit"] = f"{git.get('commit') or ''}{', with changes' * bool(git.get('dirty'))}"
            facts["command"] = " ".join(self.provenance["command"])
        yield facts
        if self.log:
            yield self.log


@dataclass(frozen=True, repr=False)
class Verification(Answer):
    """Integrity of a folder: its ``faults``, one sentence each. True if it is ``sound``: there are none."""

    sound: bool
    faults: list[str]

    def __bool__(self) -> bool:
        return self.sound

    def parts(self) -> list[str]:
        """The faults."""
        return self.faults or ["every shard is sound"]


@dataclass(frozen=True, repr=False)
class Rerun(Answer):
    """A stored run that was computed again, with the variables that are ``differing``. True if it has the
    ``same_bits``."""

    run_id: str
    same_bits: bool
    differing: list[str]

    def __bool__(self) -> bool:
        return self.same_bits

    def parts(self) -> list[str]:
        """One sentence."""
        result = f"differs in {', '.join(self.differing)}" if self.differing else "the same bits"
        return [f"run {self.run_id}: {result}"]


def status(folder: Folder) -> SweepStatus:
    """Progress of the latest sweep in a folder.

    Raises
    ------
    StoreError
        The folder contains no experiment.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "oils", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.status(results.folder)
    2 planned, 2 done, 0 failed, 0 missing (2 ok)
    """
    plan = _stored_plan(folder)
    statuses = Counter(ShardResults(plan.run_ids, plan.index, plan.failures).statuses())
    verdicts: dict[str, int] = {}
    with suppress(StoreError):
        verdicts = doubt_counts(read_texts(plan.file, VERDICT).get(VERDICT, []))
    return SweepStatus(
        planned=len(plan.run_ids),
        done=len(plan.run_ids) - len(plan.missing),
        failed=sum(count for status, count in statuses.items() if status not in ("ok", MISSING)),
        missing=len(plan.missing),
        statuses=dict(statuses),
        damaged=list(plan.index.damaged.values()),
        earlier=plan.index.n_run_of_earlier_physics,
        verdicts=verdicts,
    )


def verify(folder: Folder) -> Verification:
    """Check the checksum of every shard, and whether index and experiment file match.

    Raises
    ------
    StoreError
        The folder contains no experiment.
    """
    plan = _stored_plan(folder)
    index = read_index(plan.directory, trust=False)
    faults = [*index.damaged.values()]
    faults += [f"run {run_id}: its shard is gone or damaged" for run_id in sorted(index.lost)]
    for run_id in plan.run_ids:
        remembered, found = plan.index.runs.get(run_id), index.runs.get(run_id)
        if remembered and found and (remembered.row, remembered.status) != (found.row, found.status):
            faults.append(f"run {run_id}: the index does not match its shard {found.shard.name}")
    try:
        n_run = len(read_texts(plan.file, STATUS)[STATUS]) if plan.file.exists() else len(plan.run_ids)
    except StoreError as error:
        faults.append(str(error))
    else:
        if n_run != len(plan.run_ids):
            holds = f"holds {counted(n_run, 'run')} of {len(plan.run_ids)}"
            faults.append(f"{plan.file}: {holds}; run 'hydrofdi collect'")
    return Verification(not faults, faults)


def why(folder: Folder, run: str | int) -> Explanation:
    """A run explained: its settings, verdict and failure.

    Parameters
    ----------
    folder : path or Results
    run : str or int
        Beginning of its identity, or its row.

    Raises
    ------
    StoreError
        The folder contains no experiment, or no such run.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "oils", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.why(results.folder, 1).differences
    {'fluid.bulk_modulus': (551000000.0, 689000000.0)}
    """
    plan = _stored_plan(folder)
    position = _find(plan, run)
    spec, run_id = plan.table.runs[position], plan.run_ids[position]
    compared = plan.table.fixed_baseline[position]
    baseline = plan.experiment.nominal_parameters if compared == NO_ROW else plan.table.runs[compared].request
    stored, failure = plan.index.runs.get(run_id), plan.failures.get(run_id)
    told = read_rows(stored.shard, _SAID, [stored.row]) if stored else {}  # older shards say less
    held = {name: column[0] for name, column in told.items()}
    message, verdict = str(held.get(MESSAGE, "")), str(held.get(VERDICT, ""))
    status = stored.status if stored else failure.status if failure else "missing"
    provenance = read_provenance(plan.directory)
    return Explanation(
        run_id=run_id,
        record_id=plan.record_ids[position],
        reason=plan.reason(position) if position in plan.missing else "",
        status=status,
        message=failure.message if failure and not stored else message,
        log=failure.log if failure and not stored else "",
        causes=_causes(spec) if status == "diverged" else [],
        position=position,
        role=_role(plan.table.study, position),
        request=spec.request.shown_sections(),
        differences={
            name: (baseline.shown_value(name), spec.request.shown_value(name))
            for name in parameter_names()
            if baseline.value(name) != spec.request.value(name)
        },
        analysis=_analysis(spec, plan.record_ids[position]),
        calibration=spec.calibration.shown_sections() if spec.calibration else None,
        shard=str(stored.shard) if stored else "",
        provenance=provenance[-1] if provenance else None,
        verdict=verdict,
        doubts={doubt.word: _doubt(doubt, held) for doubt in doubts_of(verdict)},
        remedy=REMEDIES.get(status, ""),
        is_baseline=bool(compared != NO_ROW) and plan.run_ids[compared] == run_id,
        units=plan.experiment.units,
    )


def rerun(folder: Folder, run: str | int, experiment: Experiment | None = None) -> Rerun:
    """Compute a stored run again, and compare the bits.

    Parameters
    ----------
    folder, run
        As in `why`.
    experiment : path, mapping or ExperimentConfig, optional
        By default the latest request of the folder; a file of indicators is executed only if it is given.

    Raises
    ------
    StoreError
        The folder contains no experiment or no such run, or the run is not stored.
    """
    from hydrofdi.execution.compute import Job, compute_columns
    from hydrofdi.simulation.calibration import leakage_coefficients

    asked = _request(path_of(folder)) if experiment is None else load_experiment(experiment)
    plan = plan_sweep(asked, path_of(folder))
    position = _find(plan, run)
    spec, run_id = plan.table.runs[position], plan.run_ids[position]
    stored = plan.index.runs.get(run_id)
    if stored is None:
        raise StoreError(f"run {run_id} is not stored; there is nothing to compare")
    (coefficient,) = leakage_coefficients([spec], required="none")
    columns = compute_columns([Job.of(spec, run_id, coefficient, record_identity(spec))])
    computed = (*stored_variables(stored.signals, phases=True), *output_variables([spec.analysis.indicators]))
    held = read_rows(stored.shard, [variable.name for variable in computed], [stored.row])
    differing = []
    for variable in (each for each in computed if each.name in held):
        old, new = held[variable.name], np.asarray(columns[variable.name])
        new = new.astype(stored.dtype) if variable.is_signal else new
        same = np.array_equal(old, new) if variable.is_text else np.array_equal(old, new, equal_nan=True)
        if not same:
            differing.append(variable.name)
    return Rerun(run_id, not differing, differing)


def _role(roles: StudyTable | None, position: int) -> str:
    if roles is None:
        return ""
    population, design = roles.populations[roles.of_run[position]], roles.design_of_run[position]
    of_design = f", design {design + 1} of {len(roles.designs)}" if len(roles.designs) > 1 else ""
    return f"{population.title}, {'fit' if population.is_fit else 'test'} record{of_design}"


def _doubt(doubt: Doubt, held: dict[str, Any]) -> dict[str, Any]:
    number = float(held[doubt.number])
    meaning = doubt.meaning.format(f"{100.0 * float(f'{number:.2g}'):g}")
    return {"number": number, "meaning": meaning, "remedy": doubt.remedy}


def _analysis(run: RunSpec, record_id: str) -> dict[str, dict[str, Any]]:
    indicators, identities = run.analysis.indicators, run.analysis.identities(record_id)
    return {
        label: {
            "analysis_id": identities[label],
            "options": indicator.options.stated(),
            "shown": shown_options(indicator.options),
        }
        for label, indicator in indicators.items()
        if label not in run.choice.absent
    }


def _causes(run: RunSpec) -> list[str]:
    from hydrofdi.quality.machine import long_steps  # only a run that diverged loads the kernels

    return long_steps(lambda *_: [run.request])


def _request(directory: Path) -> ExperimentConfig:
    if not directory.is_dir():
        what = "is a file, not a results folder" if directory.exists() else "no such folder"
        raise StoreError(f"{directory}: {what}")
    return read_request(directory)


def _stored_plan(folder: Folder) -> SweepPlan:
    directory = path_of(folder)
    experiment = _request(directory)
    run_ids = stored_run_ids(directory, experiment) if experiment.indicator_choice.absent else None
    return plan_sweep(experiment, directory, run_ids=run_ids)


def _find(plan: SweepPlan, run: str | int) -> int:
    if isinstance(run, bool) or not isinstance(run, str | Integral):
        raise refusal("run", "its row, or the beginning of its identity", run)
    rows = rows_named(str(run), plan.run_ids, plan.record_ids, str(plan.directory))
    if len(rows) > 1:
        raise StoreError(f"{plan.directory}: {run} are {len(rows)} runs; name one of them")
    return rows[0]
