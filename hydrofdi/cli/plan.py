"""``hydrofdi plan``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Json, Results, Settings, Sweep, Workers
from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from hydrofdi.config import ExperimentConfig


def plan(
    config: Sweep,
    out: Results = None,
    workers: Workers = None,
    settings: Settings = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Count runs that failed without a result as missing.")
    ] = False,
    json: Json = False,
) -> int:
    """Show what 'hydrofdi sweep' would do, why, and how long it takes.

    Writes nothing.
    """
    from hydrofdi.api.experiments import experiment_with

    return show_plan(
        experiment_with(config, settings or ()), out, workers, retry_failed=retry_failed, json=json
    )


def show_plan(
    experiment: ExperimentConfig, out: Path | None, workers: int | None, *, retry_failed: bool, json: bool
) -> int:
    """Print the plan of a sweep."""
    from hydrofdi.api.plan import plan as make_plan
    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.config.shown_values import shown_in

    record = make_plan(experiment, out=out, workers=workers, retry_failed=retry_failed).to_dict()
    if json:
        print_json(record)
    else:
        with shown_in(experiment.units):
            write_out("\n".join(_lines(record)) + "\n")
    return 0


def _lines(record: dict[str, Any]) -> list[str]:
    from hydrofdi.settings.readable import shown_bytes, shown_seconds

    lines = [f"experiment   {record['experiment']} → {record['file']}"]
    lines += study_lines(record["study"]) if record["study"] else _run_lines(record)
    lines.append(f"stored       {record['stored']:,}")
    if record["failed_before"]:
        lines.append(f"failed       {record['failed_before']:,} before; --retry-failed tries them again")
    lines.append(f"to compute   {record['missing']:,}{_shares(record)}")
    lines += [f"  because    {reason}: {count:,}" for reason, count in record["reasons"].items()]
    lines += _solution_lines(record)
    lines.append(
        f"predicted    {shown_seconds(record['predicted_seconds'])} to"
        f" {shown_seconds(record['predicted_seconds_most'])} with"
        f" {counted(record['workers'], 'worker')},"
        f" {shown_bytes(record['predicted_file_bytes'])} (and as much in shards);"
        f" {shown_bytes(record['free_bytes'])} free"
    )
    return lines + [f"warning      {warning}" for warning in record["warnings"]]


def _run_lines(record: dict[str, Any]) -> list[str]:
    """The runs of a sweep, its axes, and its first and last point."""
    from hydrofdi.config.shown_values import shown_parameter, shown_values

    lines = [
        f"runs         {record['planned']:,}: {record['swept']:,} of the sweep,"
        f" {record['controls_added']:,} healthy ones added for comparison"
    ]
    for name, values in record["axes"].items():
        shown = shown_parameter(name, values)
        are_numbers = bool(values) and all(isinstance(value, float) for value in values)
        spread = f" from {shown.text(min(values))} to {shown.text(max(values))}" if are_numbers else ""
        header = shown.header if are_numbers else name
        lines.append(f"  axis       {header}: {counted(len(values), 'value')}{spread}")
    if record["axes"]:
        lines += [
            f"first point  {shown_values(record['first_point']) or 'nominal'}",
            f"last point   {shown_values(record['last_point']) or 'nominal'}",
        ]
    return lines


def _shares(record: dict[str, Any]) -> str:
    """The number of records to simulate for the missing runs, if it is not one for each."""
    simulated, measured = record["simulated_records"], record["measured_analyses"]
    if simulated == record["missing"]:
        return ""
    shared = f": {counted(simulated, 'record')} to simulate" if simulated else ": nothing to simulate"
    return f"{shared}, {measured:,} to measure from stored signals" if measured else shared


def _solution_lines(record: dict[str, Any]) -> list[str]:
    """The number of solutions for K_i; empty if K_i is given."""
    flows, conditions, total = record["solutions"].values()
    if not total:
        return []
    text = counted(total, "solution")
    if flows * conditions == total:
        text = f"{counted(flows, 'leakage flow')} × {counted(conditions, 'condition')} = {text}"
    if record["calibrated_at"] == "run" and conditions > 1:
        text += "; 'calibration: {at: nominal}' solves each flow once"
    return [f"K_i          {text}"]


_PURPOSES = {"alone": "to explain", "before": "to compare with"}
"""Kind of a population that is not tested → its purpose."""

_MOST_DESIGNS = 12
"""Most designs that have a line each."""


def study_lines(study: Mapping[str, Any]) -> list[str]:
    """The lines of a plan that belong to its study."""
    from hydrofdi.config.shown_values import shown_value

    designs = study["designs"]
    n_record, n_design = study["records"], len(designs)
    several = f": {n_record:,} in each of {n_design} designs" if n_design > 1 else ""
    lines = [
        f"runs         {counted(n_record * n_design, 'record')}{several}",
        *_population_lines(study["populations"]),
    ]
    if n_design > 1:
        lines += _titled("designs", [_settings(design) or "nominal" for design in designs[:_MOST_DESIGNS]])
        if n_design > _MOST_DESIGNS:
            lines.append(f"             and {n_design - _MOST_DESIGNS} more")
    width = max(map(len, study["varies"]), default=0)
    varied = [f"{name:<{width}}  {shown_value(name, own)}" for name, own in study["varies"].items()]
    lines += _titled("varies", varied or ["nothing"])
    return [*lines, f"  per record {', '.join(study['differs_per_record']) or 'nothing'}"]


def _population_lines(populations: list[dict[str, Any]]) -> Iterator[str]:
    """A line for each kind of population, and for each shift and confusion."""
    records: dict[tuple[str, str], list[str]] = {}
    sets = {(each["kind"], each["name"]): each["sets"] for each in populations}
    for each in populations:
        purpose = "to fit" if each["is_fit"] else _PURPOSES.get(each["kind"], "to test")
        own = records.setdefault((each["kind"], each["name"]), [])
        own.append(f"{each['records']:,} {purpose}")
    alike: dict[tuple[str, str, str], list[str]] = {}
    for (kind, name), counts in records.items():
        apart = f" ({_settings(sets[kind, name])})" if sets[kind, name] else ""
        alike.setdefault((kind, apart, ", ".join(counts)), []).append(name)
    for (kind, apart, count), names in alike.items():
        if names == [kind]:
            yield f"  {kind:<11}{count}"
        elif kind == "alone":
            yield f"  {kind:<11}{len(names)} populations: {count} each"
        else:
            yield f"  {kind:<11}{_listed(names)}{apart}: {count}{' each' if len(names) > 1 else ''}"


def _listed(names: list[str]) -> str:
    """Names in a list; a unit that all of them have is written once."""
    unit = names[0].partition(" ")[2]
    if len(names) > 1 and unit and all(name.endswith(f" {unit}") for name in names):
        return f"{', '.join(name.removesuffix(f' {unit}') for name in names)} {unit}"
    return ", ".join(names)


def _settings(values: Mapping[str, Any]) -> str:
    from hydrofdi.config.shown_values import shown_value

    return ", ".join(f"{name} {shown_value(name, value)}" for name, value in values.items())


def _titled(title: str, texts: list[str]) -> list[str]:
    return [f"  {title if place == 0 else '':<11}{text}" for place, text in enumerate(texts)]
