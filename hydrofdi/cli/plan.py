"""``hydrofdi plan``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, Settings
from hydrofdi.cli.plan_of_study import study_lines, study_record

if TYPE_CHECKING:
    from hydrofdi.config import ExperimentConfig
    from hydrofdi.pipeline import SweepPlan
    from hydrofdi.pipeline.planning import Prediction


def plan(
    config: Annotated[
        Path, typer.Argument(help="Experiment file with what varies, or a ready one ('hydrofdi configs').")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the results [default: results/<name>].")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes [default: the cores that hydrofdi may use].")
    ] = None,
    settings: Settings = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Count runs that failed without a result as missing.")
    ] = False,
    json: Json = False,
) -> int:
    """Say what 'hydrofdi sweep' would do, why, and for how long.

    Writes nothing.
    """
    from hydrofdi.config import load_experiment
    from hydrofdi.pipeline import experiment_directory

    experiment = load_experiment(config, settings or ())
    directory = experiment_directory(experiment, out)
    return show_plan(experiment, directory, workers, retry_failed=retry_failed, json=json)


def show_plan(
    experiment: ExperimentConfig, directory: Path, workers: int | None, *, retry_failed: bool, json: bool
) -> int:
    """Print the plan of a sweep."""
    from hydrofdi.cli.rendering import tell_doubtful_settings
    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.execution import available_cores
    from hydrofdi.pipeline import plan_sweep, predict

    tell_doubtful_settings(experiment)
    workers = workers or available_cores()
    sweep_plan = plan_sweep(experiment, directory, retry_failed=retry_failed)
    record = _record(sweep_plan, predict(sweep_plan, workers), workers)
    if json:
        print_json(record)
    else:
        write_out("\n".join(_lines(record)) + "\n")
    return 0


def _record(plan: SweepPlan, prediction: Prediction, workers: int) -> dict[str, Any]:
    from dataclasses import asdict

    from hydrofdi.config.idle_parameters import idle_parameters
    from hydrofdi.config.plausibility import distant_baseline, unusual_values
    from hydrofdi.config.sections.csv_input import without_contents

    n_run = len(plan.run_ids)
    return {
        "experiment": plan.experiment.name,
        "file": str(plan.file),
        "planned": n_run,
        "swept": plan.table.n_swept,
        "controls_added": n_run - plan.table.n_swept,
        "study": study_record(plan),
        "axes": {name: without_contents(list(values)) for name, values in _axes(plan).items()},
        "first_point": _point(plan, 0),
        "last_point": _point(plan, plan.table.n_swept - 1),
        "stored": n_run - len(plan.missing) - sum(run_id in plan.failures for run_id in plan.run_ids),
        "failed_before": sum(run_id in plan.failures for run_id in plan.run_ids),
        "missing": len(plan.missing),
        "simulated_records": plan.n_simulated,
        "measured_analyses": len(plan.measurable),
        "reasons": plan.reasons(),
        "solutions": asdict(plan.table.runs.at(plan.simulated).solutions()),
        "calibrated_at": plan.experiment.calibration.at,
        "workers": workers,
        "predicted_seconds": prediction.seconds,
        "predicted_file_bytes": prediction.file_bytes,
        "free_bytes": prediction.free_bytes,
        "warnings": plan.warnings(prediction),
        "unusual_values": unusual_values(plan.experiment) + distant_baseline(plan.experiment),
        "idle_parameters": idle_parameters(plan.experiment),
    }


def _axes(plan: SweepPlan) -> dict[str, tuple[Any, ...]]:
    """What is swept; not what a study draws."""
    swept = {*plan.experiment.ensemble.names, *plan.experiment.sweep.names}
    return {name: values for name, values in plan.table.axes.items() if name in swept}


def _point(plan: SweepPlan, position: int) -> dict[str, Any]:
    """What a point sets; of what varies elsewhere in a union only, what differs from the nominal run."""
    from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS

    experiment, parameters = plan.experiment, plan.table.runs[position].request
    throughout = experiment.ensemble.names_throughout | experiment.sweep.names_throughout
    values = {
        name: parameters.shown_value(name)
        for name in _axes(plan)
        if name in throughout or parameters.value(name) != experiment.value(name)
    }
    sealed = {name: 0.0 for name in INTERNAL_LEAKAGE_FORMS if name in values and values[name] is None}
    return values | sealed


def _lines(record: dict[str, Any]) -> list[str]:
    lines = [f"experiment   {record['experiment']} → {record['file']}"]
    lines += study_lines(record["study"]) if record["study"] else _run_lines(record)
    lines.append(f"stored       {record['stored']}")
    if record["failed_before"]:
        lines.append(f"failed       {record['failed_before']} before; --retry-failed tries them again")
    lines.append(f"to compute   {record['missing']}{_shares(record)}")
    lines += [f"  because    {reason}: {count}" for reason, count in record["reasons"].items()]
    lines += _solution_lines(record)
    lines.append(
        f"predicted    {record['predicted_seconds']:.1f} s with {record['workers']} workers,"
        f" {_megabytes(record['predicted_file_bytes'])} (and as much in shards);"
        f" {_megabytes(record['free_bytes'])} free"
    )
    return lines + [f"warning      {warning}" for warning in record["warnings"]]


def _run_lines(record: dict[str, Any]) -> list[str]:
    """The runs of a sweep, its axes, and its first and last point."""
    from hydrofdi.config.shown_values import shown_parameter, shown_values

    lines = [
        f"runs         {record['planned']}: {record['swept']} of the sweep,"
        f" {record['controls_added']} healthy ones added to compare with"
    ]
    for name, values in record["axes"].items():
        shown = shown_parameter(name, values)
        are_numbers = bool(values) and all(isinstance(value, float) for value in values)
        spread = f" from {shown.text(min(values))} to {shown.text(max(values))}" if are_numbers else ""
        lines.append(f"  axis       {shown.header}: {len(values)} values{spread}")
    if record["axes"]:
        lines += [
            f"first point  {shown_values(record['first_point']) or 'nominal'}",
            f"last point   {shown_values(record['last_point']) or 'nominal'}",
        ]
    return lines


def _shares(record: dict[str, Any]) -> str:
    """How many records are simulated for the missing runs, where that is not one for each."""
    simulated, measured = record["simulated_records"], record["measured_analyses"]
    if simulated == record["missing"]:
        return ""
    shared = f": {_counted(simulated, 'record')} to simulate" if simulated else ": nothing to simulate"
    return f"{shared}, {measured} to measure from stored signals" if measured else shared


def _solution_lines(record: dict[str, Any]) -> list[str]:
    """How often K_i is solved; empty where it is given."""
    flows, conditions, total = record["solutions"].values()
    if not total:
        return []
    text = f"{total:,} solutions"
    if flows * conditions == total:
        text = f"{_counted(flows, 'leakage flow')} × {_counted(conditions, 'condition')} = {text}"
    if record["calibrated_at"] == "run" and conditions > 1:
        text += "; 'calibration: {at: nominal}' solves each flow once"
    return [f"K_i          {text}"]


def _counted(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'s' if number > 1 else ''}"


def _megabytes(n_byte: int) -> str:
    return f"{n_byte / 1e6:,.1f} MB"
