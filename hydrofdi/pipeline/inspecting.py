"""Questions to an experiment's folder: how far it is, whether it is sound, why a run is as it is."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.config import ExperimentConfig, RunSpec
from hydrofdi.config.request import RunRequest, parameter_names
from hydrofdi.config.run_table.expansion import NO_RUN
from hydrofdi.config.shown_values import shown_options
from hydrofdi.errors import StoreError
from hydrofdi.pipeline.changes import changes_since
from hydrofdi.pipeline.identified import rows_identified
from hydrofdi.pipeline.planning import SweepPlan, plan_sweep
from hydrofdi.pipeline.results import stored_run_ids
from hydrofdi.quality.doubts import DOUBTS, Doubt, doubt_counts, doubts_of
from hydrofdi.quality.failures import remedy
from hydrofdi.settings.counting import counted
from hydrofdi.settings.file_kinds import FileKind, other_kind
from hydrofdi.simulation import record_identity
from hydrofdi.store import Columns, StoredRun, read_index
from hydrofdi.store.folder.provenance import read_provenance
from hydrofdi.store.layout.names import MESSAGE, RUN, VERDICT, Variable, stored_variables
from hydrofdi.store.layout.outputs import output_variables
from hydrofdi.store.reading import read_statuses, read_verdicts
from hydrofdi.store.request import read_request
from hydrofdi.store.results import MISSING, ShardResults
from hydrofdi.store.shard import held_names, read_variables

_SAID = (MESSAGE, VERDICT, *(doubt.number for doubt in DOUBTS.values()))


@dataclass(frozen=True, repr=False)
class SweepStatus:
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

    def __repr__(self) -> str:
        stored = ((name, n) for name, n in sorted(self.statuses.items()) if name != MISSING)
        details = ", ".join(f"{count:,} {name}" for name, count in stored)
        return (
            f"{self.planned:,} planned, {self.done:,} done, {self.failed:,} failed,"
            f" {self.missing:,} missing{f' ({details})' if details else ''}"
        )


@dataclass(frozen=True, repr=False)
class Explanation:
    """Why a run is as it is.

    Attributes
    ----------
    run_id, record_id, status, message, log : str
    reason : str
        Why it is to be computed: what of its request is not stored, its record or its analysis; empty where
        it is stored.
    causes : list of str
        The step limits that a diverged run exceeds.
    position : int
        Row in the experiment file.
    request : dict
        All that determines the run, in SI.
    differences : dict
        Dotted parameter → (value of the fixed baseline, or of the nominal run without one, value of the run),
        in SI.
    is_baseline : bool
        Whether it is the fixed baseline itself.
    analysis : dict
        Label of an indicator → its ``analysis_id``, its ``options`` that differ from the defaults, in SI, and
        these in readable units (``shown``).
    calibration : dict or None
        Conditions under which its K_i was solved.
    shard : str
        Where it is stored, empty if it is not.
    provenance : dict or None
        The latest sweep on the folder.
    verdict : str
        How far it can be believed; empty if it is not stored.
    doubts : dict
        Word of the verdict → the number behind it, what it means, and what to do about it.
    remedy : str
        What to do about a failure; empty if it did not fail.
    units : dict
        Dotted parameter → the unit that the experiment is written in.
    changes : dict
        Key of the experiment → (value of the sweep that last stored results, value now), where they differ.
    """

    run_id: str
    record_id: str
    reason: str
    status: str
    message: str
    log: str
    causes: list[str]
    position: int
    request: dict[str, Any]
    differences: dict[str, tuple[Any, Any]]
    analysis: dict[str, dict[str, Any]]
    calibration: dict[str, Any] | None
    shard: str
    provenance: dict[str, Any] | None
    verdict: str = ""
    doubts: dict[str, dict[str, Any]] = field(default_factory=dict)
    remedy: str = ""
    changes: dict[str, tuple[Any, Any]] = field(default_factory=dict)
    is_baseline: bool = False
    units: dict[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        said = [self.verdict or self.status, self.message, self.remedy, self.reason]
        said += [doubt["remedy"] for doubt in self.doubts.values()]
        return f"run {self.run_id}, row {self.position}: " + "; ".join(filter(None, said))


def sweep_status(directory: Path) -> SweepStatus:
    """How far the latest sweep on a folder is.

    Raises
    ------
    StoreError
        The folder contains no experiment.
    """
    plan = _stored_plan(directory)
    results = ShardResults(plan.run_ids, plan.index, plan.failures)
    statuses = Counter(results.statuses())
    missing = len(plan.missing)
    failed = sum(count for status, count in statuses.items() if status not in ("ok", MISSING))
    damaged = list(plan.index.damaged.values())
    planned = len(plan.run_ids)
    earlier = plan.index.n_run_of_earlier_physics
    verdicts = _verdicts(plan.file)
    return SweepStatus(
        planned, planned - missing, failed, missing, dict(statuses), damaged, earlier, verdicts
    )


def _verdicts(file: Path) -> dict[str, int]:
    """Number of runs of an experiment file with each verdict but ``ok``; empty without a readable file."""
    try:
        return doubt_counts(read_verdicts(file))
    except StoreError:
        return {}


def verify(directory: Path) -> list[str]:
    """What is wrong with an experiment's folder, one sentence each; every shard is read again.

    Raises
    ------
    StoreError
        The folder contains no experiment.
    """
    plan = _stored_plan(directory)
    index = read_index(directory, trust=False)
    faults = [*index.damaged.values()]
    faults += [f"run {run_id}: its shard is gone or damaged" for run_id in sorted(index.lost)]
    for run_id in plan.run_ids:
        remembered, found = plan.index.runs.get(run_id), index.runs.get(run_id)
        if remembered and found and (remembered.row, remembered.status) != (found.row, found.status):
            faults.append(f"run {run_id}: the index does not match its shard {found.shard.name}")
    file = plan.file
    if file.exists():
        try:
            n_run = len(read_statuses(file))
            if n_run != len(plan.run_ids):
                faults.append(
                    f"{file}: holds {counted(n_run, 'run')} of {len(plan.run_ids)}; run 'hydrofdi collect'"
                )
        except StoreError as error:
            faults.append(str(error))
    return faults


def explain(directory: Path, wanted: str, asked: ExperimentConfig | None = None) -> Explanation:
    """Why a run is as it is.

    Parameters
    ----------
    directory : Path
    wanted : str
        Beginning of the identity of a run, or its position in the experiment file.
    asked : ExperimentConfig, optional
        What is asked for now; the latest request of the folder if it is left out.

    Raises
    ------
    StoreError
        The folder contains no experiment, or no such run.
    """
    plan = _stored_plan(directory) if asked is None else plan_sweep(asked, directory)
    position = _find(plan, wanted)
    run, run_id = plan.table.runs[position], plan.run_ids[position]
    compared = plan.table.fixed_baseline[position]
    baseline = plan.experiment.nominal_parameters if compared == NO_RUN else plan.table.runs[compared].request
    stored, failure = plan.index.runs.get(run_id), plan.failures.get(run_id)
    held = _held(stored) if stored is not None else {}
    message, verdict = str(held.get(MESSAGE, "")), str(held.get(VERDICT, ""))
    status = stored.status if stored else failure.status if failure else "missing"
    provenance = read_provenance(directory)
    return Explanation(
        run_id=run_id,
        record_id=plan.record_ids[position],
        reason=plan.reason(position) if position in plan.missing else "",
        status=status,
        message=failure.message if failure and not stored else message,
        log=failure.log if failure and not stored else "",
        causes=_causes(run) if stored and stored.status == "diverged" else [],
        position=position,
        request=run.request.shown_sections(),
        differences=_differences(baseline, run.request),
        analysis=_analysis(run, plan.record_ids[position]),
        calibration=run.calibration.shown_sections() if run.calibration else None,
        shard=str(stored.shard) if stored else "",
        provenance=provenance[-1] if provenance else None,
        verdict=verdict,
        doubts={doubt.word: _doubt(doubt, held) for doubt in doubts_of(verdict)},
        remedy=remedy(status),
        changes=changes_since(directory, plan.experiment) if position in plan.missing else {},
        is_baseline=compared != NO_RUN and plan.run_ids[compared] == run_id,
        units=plan.experiment.units,
    )


def recompute(directory: Path, wanted: str) -> tuple[str, list[str]]:
    """Compute a stored run again, and compare the bits.

    Returns
    -------
    run_id : str
    differing : list of str
        Variables that came out different.

    Raises
    ------
    StoreError
        The folder contains no experiment, no such run, or the run is not stored.
    """
    plan = plan_sweep(_request(directory), directory)  # needs its indicators
    position = _find(plan, wanted)
    run, run_id = plan.table.runs[position], plan.run_ids[position]
    stored = plan.index.runs.get(run_id)
    if stored is None:
        raise StoreError(f"run {run_id} is not stored; there is nothing to compare")
    columns = _computed(run, run_id)
    computed = (*stored_variables(stored.signals, phases=True), *output_variables([run.analysis.indicators]))
    names = held_names(stored.shard)
    variables = [variable for variable in computed if variable.name in names]
    held = read_variables(stored.shard, variables, np.array([stored.row]))
    differing = []
    for variable in variables:
        old, new = held[variable.name], np.asarray(columns[variable.name])
        new = new.astype(stored.dtype) if variable.is_signal else new
        same = np.array_equal(old, new) if variable.is_text else np.array_equal(old, new, equal_nan=True)
        if not same:
            differing.append(variable.name)
    return run_id, differing


def _held(stored: StoredRun) -> dict[str, Any]:
    """What a shard says of a run: its message, verdict, and the numbers behind it; older ones say less."""
    known = held_names(stored.shard)
    variables = [Variable(name, (RUN,), "", "") for name in _SAID if name in known]
    values = read_variables(stored.shard, variables, np.array([stored.row]))
    return {name: column[0] for name, column in values.items()}


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
    }


def _causes(run: RunSpec) -> list[str]:
    from hydrofdi.assessment.step_limits import step_warnings

    return step_warnings(lambda *_: [run.request])


def _computed(run: RunSpec, run_id: str) -> Columns:
    from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients

    (coefficient,) = leakage_coefficients([run], InProcessEngine(), {}, required="none")
    return compute_columns([Job.of(run, run_id, coefficient, record_identity(run))])


def _request(directory: Path) -> ExperimentConfig:
    if not directory.is_dir():
        what = "is a file, not a results folder" if directory.exists() else "no such folder"
        raise StoreError(other_kind(directory, FileKind.RESULTS) or f"{directory}: {what}")
    return read_request(directory)


def _stored_plan(directory: Path) -> SweepPlan:
    experiment = _request(directory)
    run_ids = stored_run_ids(directory, experiment) if experiment.indicator_choice.absent else None
    return plan_sweep(experiment, directory, run_ids=run_ids)


def _find(plan: SweepPlan, wanted: str) -> int:
    n_run = len(plan.run_ids)
    if wanted.isdigit() and int(wanted) < n_run:
        return int(wanted)
    matches = rows_identified(wanted, plan.run_ids, plan.record_ids)
    if len(matches) != 1:
        found = "no run" if not matches else counted(len(matches), "run")
        rows = f"; there are rows 0 to {n_run - 1}" if wanted.isdigit() and n_run else ""
        raise StoreError(f"{plan.directory}: has {found} whose identity begins with {wanted!r}{rows}")
    return matches[0]


def _differences(baseline: RunRequest, run: RunRequest) -> dict[str, tuple[Any, Any]]:
    return {
        name: (baseline.shown_value(name), run.shown_value(name))
        for name in parameter_names()
        if baseline.value(name) != run.value(name)
    }
