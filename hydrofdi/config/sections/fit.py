"""Checks that the sections of a run fit each other; a check that fails raises ValueError."""

from __future__ import annotations

from functools import lru_cache

from hydrofdi.config.sections.analysis import AnalysisConfig
from hydrofdi.config.sections.control import ControlConfig
from hydrofdi.config.sections.csv_input import parse_rows
from hydrofdi.config.sections.fluid import FluidConfig
from hydrofdi.config.sections.input import InputConfig
from hydrofdi.config.sections.load import LoadConfig
from hydrofdi.config.sections.record import RecordConfig, is_whole
from hydrofdi.config.sections.sensor import MeasurementConfig
from hydrofdi.config.sections.supply import SupplyConfig
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import shown_quantity
from hydrofdi.transforms.configuration import WaveletConfig

MOST_OF_STEP_RATE = 0.05
"""Largest frequency of an input over the rate of the steps that hold it."""

MOST_JITTER = 0.25
"""Largest standard deviation of the sampling instants over the sampling interval."""


@lru_cache(maxsize=1024)
def require_input_fits(drive: InputConfig, control: ControlConfig, record: RecordConfig) -> None:
    """The input changes at whole steps, slowly against them, and is what the control takes."""
    _require_file_fits_control(drive, control)
    if control.is_closed:
        _require_whole_steps("control.sample_time", control.sample_time, record)
    if drive.shape == "square" and not is_whole(drive.period / (2 * record.step)):
        raise ValueError(
            f"half of input.period = {drive.period:g} s is not a multiple of record.step = {record.step:g} s"
        )
    if drive.shape == "steps":
        _require_whole_steps("input.period", drive.period, record)
    if drive.shape == "sweep" and drive.end_frequency > MOST_OF_STEP_RATE / record.step:
        raise ValueError(
            f"input.end_frequency = {drive.end_frequency:g} Hz is too fast"
            f" for record.step = {record.step:g} s"
        )
    if drive.shape == "multisine" and drive.harmonics / drive.period > MOST_OF_STEP_RATE / record.step:
        raise ValueError(
            f"harmonic {drive.harmonics} of input.period = {drive.period:g} s"
            f" is too fast for record.step = {record.step:g} s"
        )


def require_fluid_fits(fluid: FluidConfig, supply: SupplyConfig) -> None:
    """The chambers do not start cavitating."""
    start = 0.5 * (supply.pressure + supply.return_pressure)
    if fluid.vapour_pressure >= start:
        raise ValueError(
            f"fluid.vapour_pressure = {shown_quantity(fluid.vapour_pressure, 'Pa')} must be below the"
            f" {shown_quantity(start, 'Pa')} at which the chambers start, the mean of supply and return"
            " pressure"
        )


def require_load_fits(load: LoadConfig, record: RecordConfig) -> None:
    """The levels of a pseudo-random load are held for whole steps."""
    if load.random_force:
        _require_whole_steps("load.random_period", load.random_period, record)


def _require_whole_steps(name: str, time: float, record: RecordConfig) -> None:
    if not is_whole(time / record.step):
        raise ValueError(f"{name} = {time:g} s is not a multiple of record.step = {record.step:g} s")


def _require_file_fits_control(drive: InputConfig, control: ControlConfig) -> None:
    if drive.file is None:
        return
    quantity = parse_rows(drive.file).quantity
    if control.is_closed and quantity != "position":
        raise ValueError(
            f"input.file contains voltages; with control.law = {control.law} it needs positions,"
            " with a header such as 'time [s], position [mm]'"
        )
    if not control.is_closed and quantity != "voltage":
        raise ValueError("input.file contains positions; in open loop it needs voltages")


@lru_cache(maxsize=1024)
def require_discard_fits(analysis: AnalysisConfig, drive: InputConfig, record: RecordConfig) -> None:
    """What is left out of a record is a whole number of samples, and of a period that there is."""
    if analysis.discards_periods and not drive.is_periodic:
        raise ValueError(
            f"analysis.discard = {analysis.discard} needs an input with a period, and input.shape ="
            f" {drive.shape} has none; give a time"
        )
    analysis.require_whole_samples(record, drive.period)


@lru_cache(maxsize=1024)
def require_record_fits(
    record: RecordConfig, analysis: AnalysisConfig, period: float, wavelet: WaveletConfig
) -> None:
    """What is analysed of a record supports the levels of the wavelet; else, which key takes what value."""
    from pywt import Wavelet, dwt_max_level

    length = Wavelet(wavelet.name).dec_len
    n_left_out = round(analysis.discarded_time(period) * record.sampling_frequency)
    n_kept = record.n_sample - n_left_out
    deepest = dwt_max_level(max(n_kept - wavelet.latest_start, 0), length)
    if wavelet.levels <= deepest:
        return
    n_needed = (length - 1) * 2**wavelet.levels + wavelet.latest_start
    least = (n_left_out + n_needed) / record.sampling_frequency
    left = f" after analysis.discard = {analysis.shown_discard(period)}" if n_left_out else ""
    lower = f", or wavelet.levels to {deepest}" if deepest > 0 else ""
    raise ValueError(
        f"record.duration = {record.duration:g} s leaves {counted(max(n_kept, 0), 'sample')}{left}, but"
        f" wavelet.levels = {wavelet.levels} of {wavelet.name} needs {n_needed:,};"
        f" set record.duration to {least:.10g} s or more{lower}"
    )


@lru_cache(maxsize=1024)
def require_jitter_fits(measurement: MeasurementConfig, record: RecordConfig) -> None:
    """Sampling instants do not overtake each other."""
    if measurement.jitter * record.sampling_frequency > MOST_JITTER:
        raise ValueError(
            f"measurement.jitter = {measurement.jitter:g} s is more than a quarter"
            f" of the sampling interval of {1 / record.sampling_frequency:g} s"
        )
