"""Every name inside a result file, in one place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DWT, NAMED, Indicators
from hydrofdi.config.experiment import SIGNALS as SIGNALS
from hydrofdi.config.request import short_name
from hydrofdi.config.runs import Runs

FORMAT_VERSION = 4
"""Version of the layout of shards and experiment files."""

RUN, TIME, LEVEL, PHASE = "run", "time", "level", "phase"
"""Dimensions."""


@dataclass(frozen=True)
class Variable:
    """A variable of the experiment file; units in SI, ``"1"`` for numbers, ``""`` for texts and indices."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    long_name: str

    @property
    def is_text(self) -> bool:
        """Whether the variable contains text."""
        return self.name in {RUN_ID, RECORD_ID, STATUS, MESSAGE, VERDICT} or self.name.endswith(
            (ANALYSIS_ID, OBSTACLE)
        )

    def blank(self, *shape: int) -> NDArray[Any]:
        """Values of runs without a result: NaN, or empty text."""
        return np.full(shape, "", object) if self.is_text else np.full(shape, np.nan)

    @property
    def is_signal(self) -> bool:
        """Whether the variable is a signal, sampled over time."""
        return TIME in self.dimensions

    @property
    def is_mostly_still(self) -> bool:
        """Whether the variable is a signal that is constant unless certain options of the model are used."""
        return self.name in {REFERENCE_POSITION, LOAD_FORCE, VALVE_SUPPLY_PRESSURE, OIL_TEMPERATURE}


def cf_unit(unit: str) -> str:
    """A unit in the style of the CF conventions: ``m3 s-1`` for ``m^3/s``."""
    first, *divisors = unit.replace("·", " ").replace("^", "").split("/")
    factors = [*first.split(), *map(_inverse, divisors)]
    return " ".join(factors[1:] if divisors and factors[0] == "1" else factors)


def _inverse(unit: str) -> str:
    """A unit with a negative exponent: ``kg-0.5`` for ``kg0.5``."""
    name = unit.rstrip("0123456789.")
    return f"{name}-{unit[len(name) :] or 1}"


RUN_ID, RECORD_ID, STATUS, MESSAGE = "run_id", "record_id", "status", "message"
ANALYSIS_ID = ".analysis_id"
"""Suffix of an indicator label: identity of the analysis of a record."""
OBSTACLE = ".obstacle"
"""Suffix of an indicator label: why it could not measure a record. Only in files that contain such
records."""
VERDICT = "verdict"
DETAIL_RMS, APPROXIMATION_RMS = "detail_rms", "approximation_rms"
SETTLED_DETAIL_RMS, SETTLED_APPROXIMATION_RMS = "settled_detail_rms", "settled_approximation_rms"
PHASE_DETAIL_RMS, SETTLED_PHASE_DETAIL_RMS = "phase_detail_rms", "settled_phase_detail_rms"
MEAN_LEAKAGE_FLOW = "mean_internal_leakage_flow"
EXTERNAL_LEAKAGE_FLOWS = ("mean_external_leakage_flow_1", "mean_external_leakage_flow_2")
MEAN_CHAMBER_1_PRESSURE = "mean_chamber_1_pressure"
SETTLED_FROM = "settled_from"
LEAKAGE_COEFFICIENT = "internal_leakage_coefficient"
LEAKAGE_LEVEL = "internal_leakage_level"
BULK_MODULUS = "bulk_modulus"
MODE_FREQUENCY = "hydraulic_mode_frequency"
MODE_DAMPING_RATIO = "hydraulic_mode_damping_ratio"
INPUT_VOLTAGE, REFERENCE_POSITION, LOAD_FORCE = "input_voltage", "reference_position", "load_force"
VALVE_SUPPLY_PRESSURE, OIL_TEMPERATURE = "valve_supply_pressure", "oil_temperature"
CHAMBER_1_PRESSURE, CHAMBER_2_PRESSURE = "chamber_1_pressure", "chamber_2_pressure"
LARGEST_CHAMBER_1_PRESSURE = "chamber_1_pressure_max"
FIXED_BASELINE, MATCHED_BASELINE = "fixed_baseline_run", "matched_baseline_run"

MISSING = "missing"
"""Status of a run that has not been computed."""

NO_BASELINE = -1
"""Row number that means "no healthy run"."""

JUDGED = (
    Variable(VERDICT, (RUN,), "", "verdict on the quality of the run"),
    Variable("cavitating_share", (RUN,), "1", "fraction of samples below the vapour limit"),
    Variable("above_supply_share", (RUN,), "1", "fraction of samples above the supply pressure"),
    Variable("settling_change", (RUN,), "1", "largest relative change of a detail over the last two periods"),
    Variable("volume_residual", (RUN,), "1", "relative residual of the volume balance of chamber 1"),
    Variable("energy_residual", (RUN,), "1", "residual of the energy balance over the energy supplied"),
)

EXTREMES = (
    Variable("piston_position_min", (RUN,), "m", "least piston position"),
    Variable("piston_position_max", (RUN,), "m", "largest piston position"),
    Variable("chamber_1_pressure_min", (RUN,), "Pa", "least pressure of chamber 1"),
    Variable(LARGEST_CHAMBER_1_PRESSURE, (RUN,), "Pa", "largest pressure of chamber 1"),
    Variable("chamber_2_pressure_min", (RUN,), "Pa", "least pressure of chamber 2"),
    Variable("chamber_2_pressure_max", (RUN,), "Pa", "largest pressure of chamber 2"),
)

BY_LEVEL = (
    Variable(DETAIL_RMS, (RUN, LEVEL), "Pa", "RMS of the detail coefficients of the chamber-1 pressure"),
    Variable(APPROXIMATION_RMS, (RUN, LEVEL), "Pa", "RMS of the approximations of the chamber-1 pressure"),
    Variable(PHASE_DETAIL_RMS, (RUN, PHASE, LEVEL), "Pa", "RMS of the details of P_1 at each start phase"),
)
"""Outputs of the indicator ``dwt``, arranged by level: written to experiment files for other readers."""

COMPUTED = (
    Variable(RUN_ID, (RUN,), "", "identity of the run: hash of its record and its analysis"),
    Variable(STATUS, (RUN,), "", "how the run ended"),
    Variable(MESSAGE, (RUN,), "", "message of a failed run"),
    Variable(EXTERNAL_LEAKAGE_FLOWS[0], (RUN,), "m3 s-1", "mean external leakage flow out of chamber 1"),
    Variable(EXTERNAL_LEAKAGE_FLOWS[1], (RUN,), "m3 s-1", "mean external leakage flow out of chamber 2"),
    Variable(MEAN_CHAMBER_1_PRESSURE, (RUN,), "Pa", "mean pressure of chamber 1"),
    Variable("clipped_share", (RUN,), "1", "fraction of samples of P_1 at a limit of its sensor's range"),
    Variable("pressure_variation", (RUN,), "1", "range of P_1 relative to the supply pressure"),
    Variable("unusual_share", (RUN,), "1", "how far a parameter or the damping ratio misses its usual range"),
    Variable(SETTLED_FROM, (RUN,), "s", "start of the settled periods"),
    Variable(SETTLED_DETAIL_RMS, (RUN, LEVEL), "Pa", "RMS of the undecimated details of the settled P_1"),
    Variable(SETTLED_APPROXIMATION_RMS, (RUN, LEVEL), "Pa", "RMS of undecimated approximations, settled P_1"),
    Variable(RECORD_ID, (RUN,), "", "identity of the record: hash of what determines it and the physics"),
    Variable(
        SETTLED_PHASE_DETAIL_RMS,
        (RUN, PHASE, LEVEL),
        "Pa",
        "RMS of the details of the settled P_1, by start phase",
    ),
    Variable(MEAN_LEAKAGE_FLOW, (RUN,), "m3 s-1", "mean of the absolute internal leakage flow"),
    Variable(LEAKAGE_COEFFICIENT, (RUN,), "m3.5 kg-0.5", "internal leakage coefficient K_i"),
    Variable(MODE_FREQUENCY, (RUN,), "Hz", "frequency of the hydraulic mode f_h"),
    Variable(MODE_DAMPING_RATIO, (RUN,), "1", "damping ratio of the hydraulic mode"),
    *EXTREMES,
    *JUDGED,
    *(Variable(name, (RUN, TIME), cf_unit(unit), text) for name, (unit, text) in SIGNALS.items()),
)
"""Variables that a run computes; a shard contains these and the outputs of its indicators."""

REQUESTED = (
    Variable(BULK_MODULUS, (RUN,), "Pa", "effective bulk modulus of the fluid"),
    Variable(LEAKAGE_LEVEL, (RUN,), "m3 s-1", "mean leakage flow that K_i was solved for"),
    Variable(FIXED_BASELINE, (RUN,), "", "row of the healthy run under the baseline's conditions, -1: none"),
    Variable(MATCHED_BASELINE, (RUN,), "", "row of the healthy run under the run's own conditions, -1: none"),
)
"""Variables of each run that come from the experiment configuration."""


SWEPT = Variable("swept", (RUN,), "", "whether the run is a point of the sweep, not added for comparison")
"""Coordinate of runs."""


@cache
def stored_signals(signals: str) -> frozenset[str]:
    """Signals that ``store.signals`` stores."""
    return frozenset(variable.name for variable in stored_variables(signals) if variable.is_signal)


def stored_variables(signals: str, *, phases: bool = False) -> tuple[Variable, ...]:
    """Computed variables that ``store.signals`` stores, with or without those over start phases."""
    kept = NAMED[signals] if signals in NAMED else signals.split(",")
    return tuple(
        variable
        for variable in COMPUTED
        if (variable.name in kept if variable.is_signal else phases or PHASE not in variable.dimensions)
    )


FEATURES = frozenset(
    {MEAN_CHAMBER_1_PRESSURE, SETTLED_DETAIL_RMS, SETTLED_APPROXIMATION_RMS, SETTLED_PHASE_DETAIL_RMS}
)
"""Computed variables that depend on how a record is analysed."""


def axis_variable(parameter: str) -> str:
    """Name of the variable that contains a swept parameter, e.g. ``friction_viscous``."""
    return BULK_MODULUS if parameter == "fluid.bulk_modulus" else parameter.replace(".", "_")


def coordinate(parameter: str) -> str:
    """Name of the coordinate of a swept parameter, e.g. ``EBM``; else, e.g., ``swept_friction_law``."""
    short = short_name(parameter)
    taken = {RUN, TIME, LEVEL, PHASE, SWEPT.name, *(own.name for own in (*REQUESTED, *COMPUTED))}
    return f"swept_{axis_variable(parameter)}" if short in taken or "." in short else short


def is_needless(name: str, values: NDArray[Any]) -> bool:
    """Whether a variable can be omitted: obstacles if no record has one."""
    return name.endswith(OBSTACLE) and not any(values)


def output_variables(measured: Iterable[Indicators]) -> tuple[Variable, ...]:
    """Variables for the outputs of indicators, each once; only their names contain a dot."""
    variables: dict[str, Variable] = {}
    for label, indicator in (item for indicators in measured for item in indicators.items()):
        own = [
            (ANALYSIS_ID, f"identity of the analysis {label}: hash of record, indicator and options"),
            (OBSTACLE, f"why {label} could not be measured; empty if it was"),
        ]
        variables |= {f"{label}{end}": Variable(f"{label}{end}", (RUN,), "", text) for end, text in own}
        for output in indicator.outputs:
            shape = (RUN, *(f"{label}.{dimension}" for dimension in output.dims))
            name = f"{label}.{output.name}"
            variables[name] = Variable(name, shape, cf_unit(output.unit), output.long_name)
    return tuple(variables.values())


def dimensions(runs: Runs) -> dict[str, int]:
    """All dimensions of the variables of runs, and their largest lengths."""
    lengths = {RUN: len(runs), LEVEL: 0, PHASE: 0}
    for request in runs.distinct("wavelet"):
        wavelet = request.wavelet
        lengths[LEVEL] = max(lengths[LEVEL], wavelet.levels)
        if wavelet.phase == "all":
            lengths[PHASE] = max(lengths[PHASE], wavelet.latest_start + 1)
        for label, indicator in runs.choice.made(wavelet).items():
            for output in indicator.outputs:
                for dimension, length in output.dims.items():
                    name = f"{label}.{dimension}"
                    lengths[name] = max(length, lengths.get(name, 0))
    return lengths


_OUTPUT = {DETAIL_RMS: "d{}", APPROXIMATION_RMS: "a{}", PHASE_DETAIL_RMS: "d{}_phases"}
"""Variable → name pattern of the indicator outputs that it contains, by level."""


def wavelet_numbers(columns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """``detail_rms``, ``approximation_rms`` and, if measured, ``phase_detail_rms`` of runs."""
    numbers = {}
    for name, output in _OUTPUT.items():
        levels = range(1, 1 + sum(f"{DWT}.{output.format(level)}" in columns for level in range(1, 21)))
        if levels:
            arrays = [columns[f"{DWT}.{output.format(level)}"] for level in levels]
            numbers[name] = np.stack(arrays, axis=-1)
        elif name != PHASE_DETAIL_RMS:
            numbers[name] = np.full(columns[SETTLED_DETAIL_RMS].shape, np.nan)
    return numbers
