"""Checks of an experiment before it runs, and leakage coefficients of leakage flows, with their tables."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunParameters, RunTable, expand_runs
from hydrofdi.config.experiment import DEFAULT_CHOICE
from hydrofdi.config.machine import flow_at_reference
from hydrofdi.config.plausibility import unusual_parameters
from hydrofdi.config.request import OBSERVATION, SENSING
from hydrofdi.config.runs import spread
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.config.values import ParameterAnswer, modulus_column, shown_in, shown_values
from hydrofdi.engine import limited
from hydrofdi.errors import ConfigError
from hydrofdi.execution.checks import experiment_warnings, plausibility, stroke_share
from hydrofdi.execution.compute import Job, compute_columns, split_jobs
from hydrofdi.quality.machine import FIGURES, lag_limit, machine_figures, step_limits, too_long_sentence
from hydrofdi.settings.messages import (
    K_I_UNIT,
    convert,
    counted,
    number_text,
    plain,
    readable_unit,
    shown_quantity,
    typeset,
)
from hydrofdi.simulation.calibration import leakage_coefficients
from hydrofdi.simulation.lanes import WIDTH
from hydrofdi.store import names
from hydrofdi.tables.answer import Piece, Strong
from hydrofdi.tables.table import UNSAID, Column, Table, quantity

Mode = dict[str, Any]
"""One run: ``labels``, further varied parameters → their values in SI; ``bulk_modulus`` [Pa];
``leakage_coefficient`` K_i [m^3.5/kg^0.5]; ``mean_leakage_flow`` of abs(q_il), and
``leakage_flow_at_reference``, q_il at 8 MPa [m³/s]; ``piston_share``, mean leakage flow over the mean of
A_1 abs(v_p) [-]; ``frequency`` f_h [Hz] and ``damping_ratio`` ζ [-]; ``stroke_share``, largest
abs(x_p) over half of the stroke, or V/A without one [-]; ``status`` and ``verdict``. Of an FMU also
``pressure_range``, ends of P_1 [Pa]; what takes equations is NaN."""


MOST_ROWS = 24
"""Most runs that have a row each."""

_USUAL = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")


@dataclass(frozen=True, repr=False)
class Check(ParameterAnswer):
    """Findings on an experiment, as `hydrofdi.check` returns them. True if there are no problems.

    Attributes
    ----------
    step : float
        Runge-Kutta step [s].
    step_limits : dict
        Part of the model → longest stable step over all runs [s]; ``binding`` is the part with the shortest.
    figures : dict
        Statics, speeds and hydraulic mode of the nominal machine, as far as its parameters tell [SI].
    modes : list of dict
        The hydraulic mode of each run that is looked at; ``n_left_out`` further ones differ in more than
        sensors and analysis, of ``n_run`` runs in all.
    plausibility : list of dict
        Quantities of the machine and its motion, causes first, with their ``usual`` range and what to
        ``change`` if they are outside; see `plausibility`.
    problems, warnings : list of str
        What makes results wrong, and what to keep in mind when reading them.
    """

    step: float
    step_limits: dict[str, float]
    binding: str
    figures: dict[str, Any]
    modes: list[Mode]
    n_sample: int
    n_left_out: int
    n_run: int
    sampling_frequency: float
    plausibility: list[dict[str, Any]]
    problems: list[str]
    warnings: list[str]

    units: Mapping[str, str] = field(default_factory=dict, metadata=UNSAID)

    def __bool__(self) -> bool:
        return not self.problems

    def parts(self) -> Iterator[Piece]:
        """Machine, modes, step, record and warnings."""
        figures = ((*FIGURES[name], value) for name, value in self.figures.items())
        if self.figures:
            yield from (plausibility_table(self.plausibility), "", Strong("Machine, nominal"))
            yield "; ".join(f"{title} {shown_quantity(value, unit)}" for unit, title, value in figures)
            yield ""
        n_mode = len(self.modes)
        if n_mode <= MOST_ROWS:
            yield from (_modes_table(self), "")
        if self.n_left_out or n_mode > MOST_ROWS:
            n_distinct = n_mode + self.n_left_out
            kinds = f"{n_distinct:,} that differ in more than sensors, of " if n_distinct < self.n_run else ""
            yield f"{n_mode} of {kinds}{counted(self.n_run, 'run')} are simulated; --json lists each"
        step = f"step {shown_quantity(self.step, 's', 'ms', 6)}"
        if self.binding:
            limit = shown_quantity(self.step_limits[self.binding], "s", "ms", 3)
            step += f": stable up to {limit}, limited by {self.binding}"
        yield step
        yield from (counted(self.n_sample, "sample"), "")
        yield from (Strong(f"problem: {problem}") for problem in self.problems)
        yield from (f"warning: {warning}" for warning in self.warnings)
        if not (self.problems or self.warnings):
            yield "no warnings"


def checked(experiment: ExperimentConfig) -> Check:
    """Findings on an experiment, from its runs alone and from some that are simulated."""
    table = expand_runs(experiment)
    with limited(experiment.limits.time_per_job):
        jobs, n_left_out, unreached = select_runs(experiment, table)
        rows = computed_rows(jobs)
    distinct, nominal, record = table.runs.distinct, jobs[0].parameters, jobs[0].parameters.record
    labels = [name for name in table.axes if name not in _USUAL and name.partition(".")[0] not in OBSERVATION]
    modes = [_mode_of_run(job, row, labels) for job, row in zip(jobs, rows, strict=True)]
    step, limits = max(job.parameters.record.step for job in jobs), step_limits(distinct)
    for mode in modes:
        if math.isfinite(mode["frequency"]) and math.isfinite(mode["damping_ratio"]):
            limit = lag_limit(2.0 * math.pi * mode["frequency"], mode["damping_ratio"])
            limits["hydraulic mode"] = min(limit, limits.get("hydraulic mode", math.inf))
    problems = [
        too_long_sentence(part, step, limit, record.sampling_frequency)
        for part, limit in limits.items()
        if step > limit
    ]
    ends = Counter((mode["status"], mode["verdict"]) for mode in modes)
    told = {end: f"{end[1]}: {n} of {counted(len(modes), 'run')}" for end, n in ends.items()}
    messages = {str(row["status"]): str(row["message"]) for row in rows}
    problems += [f"{text}: {messages[status]}" for (status, _), text in told.items() if status != "ok"]
    problems += unreached
    with shown_in(experiment.units):
        warnings = experiment_warnings(experiment, distinct)
    unusual = unusual_parameters(experiment)
    tabled = {parameter.sentence for parameter in unusual}
    warnings += [text for (status, verdict), text in told.items() if status == "ok" != verdict]
    return Check(
        step=step,
        step_limits=limits,
        binding=min(limits, key=limits.__getitem__) if limits else "",
        figures={} if nominal.plant.fmu else machine_figures(experiment.nominal_parameters),
        modes=modes,
        n_sample=record.n_sample,
        n_left_out=n_left_out,
        n_run=len(table.runs),
        sampling_frequency=record.sampling_frequency,
        plausibility=plausibility(unusual, distinct, [job.parameters for job in jobs], rows),
        problems=problems,
        warnings=[warning for warning in dict.fromkeys(warnings) if warning not in tabled],
        units=experiment.units,
    )


def calibrated(experiment: ExperimentConfig, flows: Sequence[float]) -> Table:
    """The leakage coefficient K_i of each mean leakage flow [m³/s]."""
    sweep = SweepConfig(grid={"leakage.internal_flow": list(dict.fromkeys(flows))})
    table = expand_runs(experiment.model_copy(update={"sweep": sweep}))
    runs = table.runs[: table.n_swept]
    with limited(experiment.limits.time_per_job):
        coefficients = leakage_coefficients(runs)
    return Table((
        quantity("flow", [run.request.leakage.internal_flow for run in runs], "m^3/s", "mean leakage"),
        replace(quantity("coefficient", coefficients, K_I_UNIT, "K_i (orifice)"), text="{:.6g}".format),
    ))  # fmt: skip


def _mode_of_run(job: Job, row: Mapping[str, Any], labels: Sequence[str]) -> Mode:
    actuator = job.parameters.actuator
    mean = float(row["mean_internal_leakage_flow"])
    speed = np.mean(np.abs(row.get("piston_velocity", np.nan)))
    piston_flow = actuator.piston_area * float(speed)
    is_foreign = job.parameters.plant.fmu is not None
    ends = [float(row[f"chamber_1_pressure_{end}"]) for end in ("min", "max")]
    return {
        "labels": {name: job.parameters.shown_value(name) for name in labels},
        "bulk_modulus": job.parameters.fluid.bulk_modulus,
        "leakage_coefficient": job.leakage_coefficient,
        "mean_leakage_flow": mean,
        "leakage_flow_at_reference": float(flow_at_reference(job.leakage_coefficient)),
        "piston_share": mean / piston_flow if piston_flow else math.nan,
        "frequency": float(row["hydraulic_mode_frequency"]),
        "damping_ratio": float(row["hydraulic_mode_damping_ratio"]),
        "stroke_share": math.nan if is_foreign else stroke_share(job.parameters, row),
        "status": str(row["status"]),
        "verdict": str(row["verdict"]),
    } | ({"pressure_range": ends} if is_foreign else {})


_percent = partial(number_text, n_digit=3, scale=100.0)


def _modes_table(check: Check) -> Table:
    """The hydraulic mode of each run."""
    columns = {name: [mode[name] for mode in check.modes] for name in check.modes[0]}
    conditions = [*map(shown_values, columns["labels"])]
    if not check.figures:  # an FMU, whose equations are unknown
        ends = [[f"{convert(end, 'MPa'):.4g}" for end in pair] for pair in columns["pressure_range"]]
        return Table((
            Column("conditions", conditions, is_text=True),
            quantity("leakage_coefficient", columns["leakage_coefficient"], "", "coefficient"),
            quantity("mean_leakage_flow", columns["mean_leakage_flow"], "m^3/s", "leakage"),
            Column("pressure_range", [*map(" … ".join, ends)], title="P_1 [MPa]", is_text=True),
            Column("verdict", columns["verdict"], is_text=True),
        ), title="Runs")  # fmt: skip
    content = (
        modulus_column(columns["bulk_modulus"]),
        quantity("leakage_coefficient", columns["leakage_coefficient"], K_I_UNIT, "K_i"),
        quantity("mean_leakage_flow", columns["mean_leakage_flow"], "m^3/s", "leakage"),
        Column("piston_share", columns["piston_share"], title="of piston flow [%]", text=_percent),
        quantity("at_reference", columns["leakage_flow_at_reference"], "m^3/s", "at 8 MPa"),
        Column("frequency", columns["frequency"], "Hz", "f_h [Hz]"),
        Column("damping_ratio", columns["damping_ratio"], title="ζ"),
        Column("status", columns["status"], is_text=True, is_shown={*columns["status"]} != {"ok"}),
        Column("stroke_share", columns["stroke_share"], title="stroke used [%]", text=_percent),
        Column("conditions", conditions, is_text=True, is_shown=len({*conditions}) > 1),
    )
    return Table(content, title="Hydraulic mode in motion", n_lead=3)


def select_runs(
    experiment: ExperimentConfig, table: RunTable, most: int = WIDTH
) -> tuple[list[Job], int, list[str]]:
    """The runs of an experiment that differ in more than sensors and analysis, with their K_i and ideal
    sensors; how many are left out, and which leakage flows none of them reaches.

    Where there are more than `most`, they are spread evenly over the swept runs, and a quarter at most over
    the healthy ones that are added. In an ensemble, a leakage that cannot be reached is a run without K_i.
    """
    distinct = table.runs.first(*(name for name in RunParameters.model_fields if name not in SENSING))
    n_swept = int(np.searchsorted(distinct, table.n_swept))
    n_healthy = min(len(distinct) - n_swept, max(most // 4, most - n_swept))
    healthy = distinct[n_swept:][spread(len(distinct) - n_swept, n_healthy)]
    chosen = [*distinct[spread(n_swept, most - n_healthy)], *healthy]
    runs, unreached = list(table.runs.at(chosen)), list[str]()
    required = "none" if experiment.has_scenarios else "any"
    try:
        coefficients = leakage_coefficients(runs, required=required)  # type: ignore[arg-type]
    except ConfigError as mistake:
        # A machine that moves too little for its leaks is shown without them: its other figures say why.
        coefficients, unreached = (leakage_coefficients(runs, required="none"), [str(mistake)])
        if not any(map(math.isfinite, coefficients)):
            raise
    jobs = [
        Job(
            str(position),
            run.request.with_defaults(SENSING).parameters,
            coefficient,
            replace(run.analysis, choice=DEFAULT_CHOICE),
        )
        for position, (run, coefficient) in enumerate(zip(runs, coefficients, strict=True))
        if not unreached or math.isfinite(coefficient)
    ]
    return jobs, len(distinct) - len(jobs), unreached


def computed_rows(jobs: Sequence[Job]) -> list[dict[str, NDArray[np.float64]]]:
    """All variables of each job, in their order."""
    rows: dict[str, dict[str, Any]] = {}
    for group in split_jobs(jobs, 1):
        columns = compute_columns(group)
        del columns[names.TIME]
        for position, job in enumerate(group):
            rows[job.run_id] = {name: values[position] for name, values in columns.items()}
    return [rows[job.run_id] for job in jobs]


def plausibility_table(ranges: Sequence[Mapping[str, Any]]) -> Table:
    """The quantities, with their usual ranges, in readable units, and what to change."""

    def text(low: float, high: float, own: str) -> str:
        unit = readable_unit(own, high)
        ends = dict.fromkeys(plain(convert(end, unit, own), 3) for end in (low, high))
        return f"{' … '.join(ends)} {typeset(unit)}".removesuffix(" 1").rstrip()

    columns = {
        "quantity": [row["quantity"] for row in ranges],
        "here": [text(row["least"], row["largest"], row["unit"]) for row in ranges],
        "usual": [text(row["usual"][0], row["usual"][1], row["unit"]) for row in ranges],
    }
    notes = (f"{row['quantity']}: {row['change']}" for row in ranges if row["change"])
    return Table.of(columns, title="Plausibility", notes=tuple(notes))
