"""Plans of sweeps."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from os import PathLike
from typing import Any

from hydrofdi.api.arguments import count_of
from hydrofdi.api.experiments import Experiment, stated_experiment
from hydrofdi.api.page import html_sentences
from hydrofdi.api.places import path_of
from hydrofdi.api.plan_of_study import study_record
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig
from hydrofdi.config.idle_parameters import idle_parameters
from hydrofdi.config.plausibility import distant_baseline, unusual_values
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.shown_values import shown_in
from hydrofdi.execution import available_cores
from hydrofdi.pipeline.places import experiment_directory
from hydrofdi.pipeline.planning import SweepPlan, plan_sweep, predict_seconds
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import shown_seconds


@dataclass(frozen=True, repr=False)
class Plan:
    """What a sweep will do, as `hydrofdi.plan` returns it.

    Attributes
    ----------
    experiment, file : str
        Name of the experiment, and where its file will be.
    planned, swept, controls_added : int
        All runs; those of the sweep; healthy ones that are added to compare with.
    study : dict or None
        Populations and designs of a study of detection, and what varies.
    axes : dict
        Dotted parameter → its values, in SI.
    first_point, last_point : dict
        What the first and the last run of the sweep set, in SI.
    stored, failed_before, missing : int
        Runs that are stored, that failed before, and that are to be computed.
    simulated_records, measured_analyses : int
        Records to simulate for these, and analyses to measure from stored signals.
    reasons : dict
        Why runs are to be computed → how many.
    solutions : dict
        Leakage flows, conditions and total of the leakage coefficients K_i to solve.
    calibrated_at : str
        Whether K_i is solved for each run, or at the nominal actuator.
    workers : int
    predicted_seconds, predicted_seconds_most : float
        Least and most wall time to expect with so many workers, from a few runs that were tried [s].
    predicted_file_bytes, free_bytes : int
        Size of the experiment file (the shards take as much again), and free space.
    warnings : list of str
        Warnings, one sentence each.
    unusual_values, idle_parameters : list of str
        Those of the warnings that are about unusual values, and about parameters without effect.
    units : dict
        Dotted parameter → the unit that the experiment is written in.
    """

    experiment: str
    file: str
    planned: int
    swept: int
    controls_added: int
    study: dict[str, Any] | None
    axes: dict[str, Any]
    first_point: dict[str, Any]
    last_point: dict[str, Any]
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
    unusual_values: list[str]
    idle_parameters: list[str]
    units: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi plan --json`` prints."""
        return asdict(self)

    def _repr_html_(self) -> str:
        return html_sentences(repr(self), self.warnings)

    def __repr__(self) -> str:
        least, most = shown_seconds(self.predicted_seconds), shown_seconds(self.predicted_seconds_most)
        return (
            f"{self.experiment}: {self.missing:,} of {counted(self.planned, 'run')} to compute in {least} to"
            f" {most}, {counted(len(self.warnings), 'warning')}"
        )


def plan(
    experiment: Experiment,
    /,
    *,
    out: str | PathLike[str] | None = None,
    workers: int | None = None,
    retry_failed: bool = False,
    **settings: Any,
) -> Plan:
    """What `hydrofdi.sweep` would do, as ``hydrofdi plan`` says it. Writes nothing.

    Parameters
    ----------
    experiment, out, workers, retry_failed, **settings
        As in `hydrofdi.sweep`.

    Raises
    ------
    ConfigError
        With every mistake.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "planned", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> plan = hydrofdi.plan(study)
    >>> plan
    planned: 2 of 2 runs to compute in 0... s to 1... s, ... warnings
    >>> plan.reasons
    {'new': 2}
    """
    workers = available_cores() if workers is None else count_of("workers", workers)
    loaded = stated_experiment(experiment, settings)
    with shown_in(loaded.units):
        return _planned(loaded, out, workers, retry_failed)


def _planned(
    loaded: ExperimentConfig, out: str | PathLike[str] | None, workers: int, retry_failed: bool
) -> Plan:
    directory = experiment_directory(loaded, None if out is None else path_of(out))
    made = plan_sweep(loaded, directory, retry_failed=retry_failed)
    n_run = len(made.run_ids)
    least, most = predict_seconds(made, workers)
    failed = sum(run_id in made.failures for run_id in made.run_ids)
    return Plan(
        experiment=loaded.name,
        file=str(made.file),
        planned=n_run,
        swept=made.table.n_swept,
        controls_added=n_run - made.table.n_swept,
        study=study_record(made),
        axes={name: without_contents(list(values)) for name, values in _axes(made).items()},
        first_point=_point(made, 0),
        last_point=_point(made, made.table.n_swept - 1),
        stored=n_run - len(made.missing) - failed,
        failed_before=failed,
        missing=len(made.missing),
        simulated_records=made.n_simulated,
        measured_analyses=len(made.measurable),
        reasons=made.reasons(),
        solutions=asdict(made.table.runs.at(made.simulated).solutions()),
        calibrated_at=loaded.calibration.at,
        workers=workers,
        predicted_seconds=least,
        predicted_seconds_most=most,
        predicted_file_bytes=made.file_bytes,
        free_bytes=made.free_bytes,
        warnings=made.warnings,
        unusual_values=unusual_values(loaded) + distant_baseline(loaded),
        idle_parameters=idle_parameters(loaded),
        units=loaded.units,
    )


def _axes(plan: SweepPlan) -> dict[str, tuple[Any, ...]]:
    """What is swept; not what a study draws."""
    swept = {*plan.experiment.ensemble.names, *plan.experiment.sweep.names}
    return {name: values for name, values in plan.table.axes.items() if name in swept}


def _point(plan: SweepPlan, position: int) -> dict[str, Any]:
    """What a point sets; of what varies elsewhere in a union only, what differs from the nominal run."""
    experiment, parameters = plan.experiment, plan.table.runs[position].request
    throughout = experiment.ensemble.names_throughout | experiment.sweep.names_throughout
    values = {
        name: parameters.shown_value(name)
        for name in _axes(plan)
        if name in throughout or parameters.value(name) != experiment.value(name)
    }
    sealed = {name: 0.0 for name in INTERNAL_LEAKAGE_FORMS if name in values and values[name] is None}
    return values | sealed
