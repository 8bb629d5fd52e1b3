"""The sections of the analysis: discarded time, wavelet, and how a record fits."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from hydrofdi.config.sections.csv_input import parse_rows
from hydrofdi.config.sections.drive import ControlConfig, InputConfig, RecordConfig, is_whole
from hydrofdi.config.sections.machine import FluidConfig, LeakageConfig, LoadConfig, SupplyConfig
from hydrofdi.config.sections.plant import PlantConfig
from hydrofdi.config.sections.sensor import MeasurementConfig
from hydrofdi.settings.messages import counted, shown_quantity
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.transforms import WaveletConfig

_PERIODS = re.compile(r"\s*((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*periods?\s*")


@dataclass(frozen=True)
class TimeOrPeriods(SI):
    """Annotation of a time from zero on [s], or of a number of periods, held as a text like ``2 periods``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Parse, and check a time's limit."""
        return core_schema.no_info_plain_validator_function(self._time_or_periods)

    def _time_or_periods(self, value: Any) -> float | str:
        periods = _PERIODS.fullmatch(value) if isinstance(value, str) else None
        if periods is not None:
            number = float(periods[1])
            return f"{number:.15g} {'period' if number == 1.0 else 'periods'}"
        if isinstance(value, str) and value.rstrip().endswith(("period", "periods")):
            raise ValueError(f"must be zero or more periods, such as '1 period'; found {value!r}")
        time = self.parse(value)
        if not 0.0 <= time < math.inf:
            raise ValueError(f"must be zero or a positive time; found {value}")
        return time


class AnalysisConfig(Section):
    """The analysed part of a record. It can change without a new simulation."""

    discard: Annotated[float | str, TimeOrPeriods("s", least=0)] = 0.0
    """Initial part of the record that indicators and features ignore: a time [s], or periods of the input
    such as ``1 period``, for any ``input.period``. Signals still contain it, and so do the values of the
    plant itself: leakage flows, extremes, hydraulic mode, settling."""

    def discarded_time(self, period: float) -> float:
        """Start of the record that is left out, for an input of some period [s]."""
        if isinstance(self.discard, str):
            return float(self.discard.split()[0]) * period
        return self.discard

    def shown_discard(self, period: float) -> str:
        """What is left out, for a period of the input [s]: ``4 s``, ``1 period of input.period = 2 s``."""
        if isinstance(self.discard, str):
            return f"{self.discard} of input.period = {period:g} s"
        return f"{self.discard:g} s"


MOST_JITTER = 0.25
"""Largest standard deviation of the sampling instants over the sampling interval."""


@lru_cache(maxsize=1024)
def require_input_fits(drive: InputConfig, control: ControlConfig, record: RecordConfig) -> None:
    """The input changes at whole steps, and is what the control takes."""
    needed = "position" if control.is_closed else "voltage"
    if drive.file is not None and (quantity := parse_rows(drive.file).quantity) != needed:
        raise ValueError(
            f"input.file contains a {quantity}; with control.law = {control.law} it needs a {needed}"
        )
    if control.is_closed:
        _require_whole_steps("control.sample_time", control.sample_time, record)
    if drive.shape == "square" and not is_whole(drive.period / (2 * record.step)):
        raise ValueError(
            f"half of input.period = {drive.period:g} s is not a multiple of record.step = {record.step:g} s"
        )
    if drive.shape == "steps":
        _require_whole_steps("input.period", drive.period, record)


def require_fluid_fits(fluid: FluidConfig, supply: SupplyConfig) -> None:
    """The chambers do not start cavitating."""
    start = 0.5 * (supply.pressure + supply.return_pressure)
    if fluid.vapour_pressure >= start:
        raise ValueError(
            f"fluid.vapour_pressure = {shown_quantity(fluid.vapour_pressure, 'Pa')} must be below the"
            f" {shown_quantity(start, 'Pa')} at which the chambers start, the mean of supply and return"
            " pressure"
        )


def require_plant_fits(
    plant: PlantConfig, control: ControlConfig, leakage: LeakageConfig, record: RecordConfig
) -> None:
    """An FMU has the variables that the controller and the leak need, and takes the communication step."""
    if plant.fmu is None:
        return
    fixed = plant.model.fixed_step if plant.model is not None else None
    if fixed is not None and not is_whole(record.step / fixed):
        raise ValueError(
            f"record.step = {record.step:g} s is not a multiple of the {fixed:g} s that {plant.name} takes"
        )
    is_inside = "reference_position" in plant.inputs
    if control.is_closed and not is_inside and "piston_position" not in plant.outputs:
        raise ValueError(f"control.law = {control.law} reads the position: name it in plant.outputs")
    if not (is_inside or "input_voltage" in plant.inputs):
        raise ValueError("plant.inputs needs input_voltage, or reference_position of a controller inside")
    if (leakage.internal_coefficient or leakage.internal_flow) and plant.leakage.coefficient is None:
        raise ValueError("an internal leak needs plant.leakage.coefficient, the parameter that sets it")
    if leakage.internal_flow and "internal_leakage_flow" not in plant.outputs:
        raise ValueError(
            "leakage.internal_flow is solved from the flow of the leak, which is not among plant.outputs:"
            " name it as internal_leakage_flow, or state leakage.internal_coefficient"
        )


def require_load_fits(load: LoadConfig, record: RecordConfig) -> None:
    """The levels of a pseudo-random load are held for whole steps."""
    if load.random_force:
        _require_whole_steps("load.random_period", load.random_period, record)


def _require_whole_steps(name: str, time: float, record: RecordConfig) -> None:
    if not is_whole(time / record.step):
        raise ValueError(f"{name} = {time:g} s is not a multiple of record.step = {record.step:g} s")


@lru_cache(maxsize=1024)
def require_discard_fits(analysis: AnalysisConfig, drive: InputConfig, record: RecordConfig) -> None:
    """What is left out of a record is a whole number of samples, and of a period that there is."""
    if isinstance(analysis.discard, str) and not drive.is_periodic:
        raise ValueError(
            f"analysis.discard = {analysis.discard} needs an input with a period, and input.shape ="
            f" {drive.shape} has none; give a time"
        )
    time, shown = analysis.discarded_time(drive.period), analysis.shown_discard(drive.period)
    if time and not is_whole(time * record.sampling_frequency):
        raise ValueError(f"analysis.discard = {shown} is not a multiple of the sampling interval")


@lru_cache(maxsize=1024)
def require_record_fits(
    record: RecordConfig, analysis: AnalysisConfig, drive: InputConfig, wavelet: WaveletConfig
) -> None:
    """What is analysed of a record supports the levels of the wavelet; else, which key takes what value."""
    from pywt import Wavelet, dwt_max_level

    length = Wavelet(wavelet.name).dec_len
    n_left_out = round(analysis.discarded_time(drive.period) * record.sampling_frequency)
    n_kept = record.n_sample - n_left_out
    deepest = dwt_max_level(max(n_kept - wavelet.latest_start, 0), length)
    if wavelet.levels <= deepest:
        return
    n_needed = (length - 1) * 2**wavelet.levels + wavelet.latest_start
    least = (n_left_out + n_needed) / record.sampling_frequency
    left = f" after analysis.discard = {analysis.shown_discard(drive.period)}" if n_left_out else ""
    lower = f", or wavelet.levels to {deepest}" if deepest > 0 else ""
    raise ValueError(
        f"record.duration = {record.duration:g} s leaves {counted(max(n_kept, 0), 'sample')}{left}, but"
        f" wavelet.levels = {wavelet.levels} of {wavelet.name} needs {n_needed:,};"
        f" set record.duration to {least:.10g} s or more{lower}"
    )


@lru_cache(maxsize=1024)
def require_jitter_fits(measurement: MeasurementConfig, record: RecordConfig) -> None:
    """Sampling instants do not overtake each other."""
    if measurement.jitter * record.sampling_frequency > MOST_JITTER + 1e-9:
        raise ValueError(
            f"measurement.jitter = {measurement.jitter:g} s is more than a quarter"
            f" of the sampling interval of {1 / record.sampling_frequency:g} s"
        )
