"""What is said of an experiment: rules that give sentences, and usual ranges of quantities."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.drive import is_whole
from hydrofdi.config.plausibility import Unusual, idle_parameters, study_mistakes, unusual_values
from hydrofdi.config.request import EDGES, OWN_PLANT, RunRequest, parameter_names
from hydrofdi.config.values import shown_value
from hydrofdi.indicators.nominal_actuator import constants_not_given, sheet_constants
from hydrofdi.quality.machine import Distinct, at_speed, is_near_band_edge, long_steps, natural_frequency
from hydrofdi.records import RecordBatch
from hydrofdi.records.data_sheet import PLANT_PARAMETERS, is_other
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import Section
from hydrofdi.store.experiment_data import SIGNAL_OF_CHANNEL

MOST_RECORDS = 200
"""Kinds of records that indicators are tried on; a drawn period would make one for each run."""

_OF_WAVELETS = ("dwt", "a4", "modwt", "wavelet_packet")
_OF_RECORDS = ("input", "load", "record", "analysis", "wavelet")


def likely_mistakes(
    experiment: ExperimentConfig, distinct: Distinct, *, with_sweep: bool = True
) -> list[str]:
    """Unusual values, parameters without effect, and steps that are too long: what every run is told."""
    doubts = unusual_values(experiment, with_sweep=with_sweep) + idle_parameters(experiment)
    return doubts + long_steps(distinct)


def experiment_warnings(experiment: ExperimentConfig, distinct: Distinct) -> list[str]:
    """What every rule says; `distinct` gives one run for each combination of sections."""
    said = unusual_values(experiment) + idle_parameters(experiment)
    said += (text for rule in RULES for text in rule(experiment, distinct))
    return said + study_mistakes(experiment)


def _bands(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A mode near the edge of a band, if an indicator has the bands of a wavelet transform."""
    made = experiment.indicator_choice.made(experiment.wavelet).values()
    if not any(getattr(indicator.options, "of", indicator.name) in _OF_WAVELETS for indicator in made):
        return
    for run in distinct("actuator", "fluid", "supply", "record", "wavelet"):
        if run.plant.fmu is None and is_near_band_edge(run):
            modulus = shown_value("fluid.bulk_modulus", run.fluid.bulk_modulus)
            yield (
                f"Two wavelet levels share the natural frequency, {natural_frequency(run):.1f} Hz at EBM"
                f" {modulus}, so their values depend strongly on the oil. Another record.sampling_frequency"
                " moves the levels; other indicators are not affected"
            )
            return


def _folding(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """What is too fast for the sampling."""
    for run in distinct("measurement", "record"):
        corner, half = run.measurement.anti_alias or 0.0, 0.5 * run.record.sampling_frequency
        if corner >= half:
            yield (
                f"measurement.anti_alias: {corner:g} Hz is not below {half:g} Hz, half of"
                " record.sampling_frequency"
            )


def _doubts_of_fmu(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """What an FMU needs, leaves open, or does not do."""
    plant = experiment.plant
    if (model := plant.model) is None:
        return
    if model.needed_tool:
        yield f"{plant.name} needs {model.needed_tool} while it runs (needsExecutionTool)"
    signals = {**plant.inputs, **plant.outputs}
    bare = [text for text in signals.values() if text in model.variables and not model.variables[text].unit]
    if bare:
        yield f"no unit, taken in SI: {', '.join(bare)}; state others as in '{bare[0]} [bar]'"
    if idle := [
        name
        for name in parameter_names()
        if name.partition(".")[0] in OWN_PLANT and name not in plant.parameters
        and experiment.value(name) != RunRequest().value(name)
    ]:  # fmt: skip
        yield f"{', '.join(idle)}: of no effect on {plant.name}, but constants of the machine for indicators"
    for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items():
        if names := constants_not_given(indicator.options):
            yield (
                f"{label} assumes the machine of the paper for {', '.join(names)}: state yours under"
                " actuator, supply, fluid and valve"
            )


def _periods(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    for run in distinct("input", "record"):
        if run.input.is_periodic and not is_whole(n_period := run.record.duration / run.input.period):
            yield f"the record holds {n_period:g} periods, no whole number: features depend on where it ends"


def without_results(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on each indicator that cannot measure the records of some runs, and why."""
    records = dict.fromkeys(
        (run.n_kept, run.record.sampling_frequency, run.drive_period, run.wavelet)
        for run in distinct(*_OF_RECORDS)
    )
    for n_kept, frequency, period, wavelet in islice(records, MOST_RECORDS):
        channels = (
            channel
            for channel, signal in SIGNAL_OF_CHANNEL.items()
            if signal not in experiment.absent_signals
        )
        signals = dict.fromkeys(channels, np.broadcast_to(0.0, (1, n_kept)))
        batch = RecordBatch(signals, frequency, ("",), drive_period=period)
        for label, indicator in experiment.indicator_choice.made(wavelet).items():
            if text := indicator.obstacle(batch):
                yield f"{label} will have no results: {text}"


def other_machines(experiment: ExperimentConfig, distinct: Distinct) -> Iterator[str]:
    """A sentence on each indicator whose constants of the plant are not those of the nominal machine."""
    for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items():
        if text := ", ".join(_differing(experiment, indicator.options)):
            yield f"{label}: the options describe another machine: {text}"


def _differing(experiment: ExperimentConfig, options: Section) -> Iterator[str]:
    """Stated constants of an indicator that differ from the parameters of the same meaning."""
    sheet = experiment.data_sheet
    for constant in sheet_constants(options):
        assumed, simulated = getattr(options, constant), sheet.get(constant)
        if (constant in sheet or constant in PLANT_PARAMETERS) and is_other(assumed, simulated):
            parameter = PLANT_PARAMETERS.get(constant, "the simulated one is")
            own, other = (
                "not stated" if value is None else shown_value(parameter, value)
                for value in (assumed, simulated)
            )
            yield f"{constant} {own}, but {parameter} {other}"


_MUCH = 0.1
"""Share of the samples at the limit from which on the limit decides the motion."""

_SLACK = 1e-3
"""Relative distance from the limit that still counts as being there."""


def saturation(run: RunParameters, voltage: NDArray[np.float64]) -> Iterator[str]:
    """A sentence if the controller is at its limit for much of a record of the input voltage [V]."""
    limit = run.control.voltage_limit
    share = float(np.mean(np.abs(voltage) >= (1.0 - _SLACK) * limit))
    if run.control.is_closed and share >= _MUCH:
        yield (
            f"the controller is at control.voltage_limit = {shown_value('control.voltage_limit', limit)} in"
            f" {100.0 * share:.0f} % of the samples; set it to the range of your valve, or lower"
            " control.amplitude or control.proportional_gain"
        )


Rule = Callable[[ExperimentConfig, Distinct], Iterable[str]]

RULES: tuple[Rule, ...] = (_bands, _folding, _doubts_of_fmu, _periods, without_results, other_machines)
"""Rules that hold for every experiment."""


Row = Mapping[str, Any]


class CheckedQuantity(NamedTuple):
    """A quantity [in `unit`] of a run and its row of results; its usual range, what to change
    below and above it, and the sections that it depends on if it needs no results.
    """

    name: str
    unit: str
    least: float
    most: float
    of: Callable[[RunParameters, Row], float]
    below: str
    above: str
    sections: tuple[str, ...] = ()


def load_share(run: RunParameters, row: Row) -> float:
    """Largest load of forces, weight and spring, over supply pressure times the smaller area [%]."""
    actuator, load = run.actuator, run.load
    force = abs(load.constant_force + actuator.weight) + load.random_force
    reached = max(abs(float(row[f"piston_position_{end}"])) for end in ("min", "max"))
    # A run that failed has no positions; its load is that of the forces.
    force += actuator.load_stiffness * (reached if math.isfinite(reached) else 0.0)
    return 100.0 * force / (run.supply.pressure * min(actuator.areas))


def stroke_share(run: RunParameters, row: Row) -> float:
    """Largest abs(x_p) over half of the stroke, or over V/A without one [-]."""
    used = (float(row[f"piston_position_{end}"]) for end in ("min", "max"))
    return max(position / end for position, end in zip(used, run.actuator.ends, strict=True))


def valve_speed(run: RunParameters, *, slower: bool) -> float:
    """Steady speed at the largest opening, in the slower or the faster direction [m/s]."""
    return (min if slower else max)(at_speed(run, motion)[0] for motion in (1.0, -1.0))


def speed_ratio(run: RunParameters) -> float:
    """Speed that the valve allows in the slower direction over the largest that a reference asks for [-].

    NaN without a reference whose period states a speed.
    """
    shares = {"square": 4.0, "steps": 2.0, "sine": 2.0 * math.pi}
    if not run.control.is_closed or run.input.shape not in shares or not run.control.amplitude:
        return math.nan
    asked = shares[run.input.shape] * abs(run.control.amplitude) / run.input.period
    return valve_speed(run, slower=True) / asked


def slenderness(run: RunParameters) -> float:
    """Stroke, or where a chamber vanishes, over the diameter of a circle of the area A_1 [-]."""
    low, high = run.actuator.ends
    return (high - low) / math.sqrt(4.0 / math.pi * run.actuator.piston_area)


_OF_SPEED = ("actuator", "supply", "valve", *EDGES, "load", "input", "control", "record")

QUANTITIES = (
    CheckedQuantity(
        "stroke over piston diameter", "", 0.1, 40.0, lambda run, row: slenderness(run),
        "check actuator.stroke and actuator.piston_area",
        "check actuator.stroke, without it actuator.chamber_volume: a rod of this length buckles",
        ("actuator",),
    ),
    CheckedQuantity(
        "natural frequency f_h", "Hz", 1.0, 500.0, lambda run, row: natural_frequency(run),
        "check fluid.bulk_modulus and the units of actuator.piston_area; or lower actuator.mass",
        "check actuator.mass; or raise actuator.chamber_volume",
        ("actuator", "fluid", "supply"),
    ),
    CheckedQuantity(
        "load over the force", "%", 5.0, 75.0, load_share,
        "raise load.constant_force or load.random_force: a seal without a load hardly leaks",
        "check supply.pressure and actuator.piston_area; or lower the load",
    ),
    CheckedQuantity(
        "largest valve speed", "m/s", 0.005, 1.5,
        lambda run, row: valve_speed(run, slower=False),
        "raise valve.area_gradient; check the pressure drop of the rated flow",
        "lower valve.area_gradient; check the pressure drop of the rated flow",
        _OF_SPEED,
    ),
    CheckedQuantity(
        "valve speed over motion speed", "", 1.0, 10.0, lambda run, row: speed_ratio(run),
        "raise valve.area_gradient; or lower control.amplitude, or raise input.period",
        "lower valve.area_gradient; or raise control.amplitude, or lower input.period",
        _OF_SPEED,
    ),
    CheckedQuantity(
        "stroke used", "%", 5.0, 95.0, lambda run, row: 100.0 * stroke_share(run, row),
        "raise control.amplitude (open loop: input.amplitude)",
        "lower control.amplitude (open loop: input.amplitude or input.period)",
    ),
    CheckedQuantity(
        "hydraulic damping ζ, in motion", "", 0.02, 1.0,
        lambda run, row: float(row["hydraulic_mode_damping_ratio"]),
        "raise friction.viscous or valve.lap_leakage: real cylinders are damped better",
        "lower friction.viscous, or check the leakage",
    ),
    CheckedQuantity(
        "time with a cavitating chamber", "%", 0.0, 0.0,
        lambda run, row: 100.0 * float(row["cavitating_share"]),
        "",
        "lower the load, or control.voltage_limit: the valve cannot feed the chamber that the load opens",
    ),
)  # fmt: skip
"""What follows from the parameters first, then what the motion shows."""


def plausibility(
    unusual: Iterable[Unusual], distinct: Distinct, runs: Sequence[RunParameters], rows: Sequence[Row]
) -> list[dict[str, Any]]:
    """Unusual parameters, and the range of each quantity, with their usual range.

    What needs no results is that of all machines, all else that of the simulated runs. ``change`` says what
    to change if some value is outside, and in how many of them if not in all.
    """
    ranges = [
        (rare.name, rare.unit, [*map(abs, rare.values)], rare.usual, "check its value and its unit")
        for rare in unusual
    ]
    for quantity in QUANTITIES if runs[0].plant.fmu is None else ():
        seen: Iterable[tuple[RunParameters, Row]] = zip(runs, rows, strict=True)
        if quantity.sections:
            seen = ((run, {}) for run in distinct(*quantity.sections))
        own = [value for run_and_row in seen if math.isfinite(value := float(quantity.of(*run_and_row)))]
        n_low, n_high = sum(size < quantity.least for size in own), sum(size > quantity.most for size in own)
        change = quantity.below if n_low > n_high else quantity.above if n_high else ""
        n_outside = max(n_low, n_high)
        of_all = counted(len(own), "machine" if quantity.sections else "run")
        where = f"in {n_outside} of {of_all}: " if 0 < n_outside < len(own) else ""
        if own:
            usual = quantity.least, quantity.most
            ranges.append((quantity.name, quantity.unit, own, usual, where + change))
    return [
        {
            "quantity": name,
            "unit": unit,
            "least": min(values),
            "largest": max(values),
            "usual": [*usual],
            "change": change,
        }
        for name, unit, values, usual, change in ranges
    ]
