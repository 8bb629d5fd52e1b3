"""The sections of the drive: input, control, record; and the user's own input as a CSV file.

A configuration holds the contents of the file, not its path, as a text of one form::

    # drive.csv
    time [s],voltage [V]
    0.0,2.0
    0.5,-2.0

The first line is a name for people; everything else is the input's identity. Each value holds until the
next time.
"""

from __future__ import annotations

import hashlib
import math
import sys
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from hydrofdi.config.machine import LoadConfig
from hydrofdi.errors import DataError
from hydrofdi.settings import quantities as usual
from hydrofdi.settings.files import read_text
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.units import parse_si, parse_unit

MOST_ROWS = 100_000
"""Rows that a file may have."""

_MOST_BYTES = 100 * MOST_ROWS
_UNITS = {"voltage": "V", "position": "m"}


@dataclass(frozen=True, eq=False)
class HeldRows:
    """Values of a ``voltage`` [V] or ``position`` [m] that hold from their times [s] on, (n_row,)."""

    quantity: str
    times: NDArray[np.float64]
    values: NDArray[np.float64]


def input_contents(given: str, info: ValidationInfo) -> str:
    """Contents of a CSV file, or of a text of lines; stored experiments (with a context) name no file."""
    if "\n" in given:
        first = given.partition("\n")[0]
        return held_text(first.removeprefix("# ") if first.startswith("# ") else "text", given)
    if info.context is not None:
        raise ValueError(f"{given!r} is a path; only experiment files and settings name files")
    path, kind = Path(given), "an input of times and values"
    if path.exists() and not path.is_dir() and (not path.is_file() or path.stat().st_size > _MOST_BYTES):
        raise ValueError(f"{path}: is no file, or larger than the {_MOST_BYTES / 1e6:g} MB of an input")
    return held_text(path.name, read_text(path, kind).removeprefix("\ufeff"), given)


@lru_cache(maxsize=64)
def held_text(name: str, text: str, place: str = "text") -> str:
    """A CSV text in the form that a configuration holds, with a name for people, and a place for messages."""
    rows = parse_rows(text, place)
    pairs = zip(rows.times.tolist(), rows.values.tolist(), strict=True)
    lines = [f"# {' '.join(name.split())}", f"time [s],{rows.quantity} [{_UNITS[rows.quantity]}]"]
    lines += [f"{time!r},{value!r}" for time, value in pairs]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def parse_rows(text: str, place: str = "text") -> HeldRows:
    """The rows of a CSV text."""
    # only an experiment with a file loads the reader of measured files
    from hydrofdi.records.columns import short_name
    from hydrofdi.records.description import FormatConfig, known_unit
    from hydrofdi.records.text import TextTable

    def require(is_met: bool, message: str, row: int = -1) -> None:
        if not is_met:
            raise ValueError(f"{table.row_place(row)}: {message}")

    try:
        table = TextTable(place, FormatConfig(decimal="."), lambda: iter([[*text.splitlines(), ""]]))
        columns = [table.numbers(n) for n in range(len(table.titles))]
        units = [table.unit(n) for n in range(len(table.titles))]
    except DataError as error:
        raise ValueError(str(error).partition(";")[0]) from None  # the rest tells of descriptions
    n_row, n_column = columns[0].size, len(columns)
    if not 1 <= n_row <= MOST_ROWS:
        raise ValueError(f"{place}: contains {counted(n_row, 'row')}; needs 1 to {MOST_ROWS}")
    widest = int(np.argmax(np.isfinite(columns[-1])))
    require(n_column == 2, f"expected two columns, time and voltage; found {n_column}", widest)
    is_cut = any(remark.kind == "truncated" for remark in table.remarks)
    require(not is_cut, "expected two columns, time and voltage", n_row)
    named = "position" if short_name(table.titles[1]) == "position" else "voltage"
    units = [units[0] or "s", units[1] or _UNITS[named]]
    dimensions = [unit and unit.exponents for unit in map(known_unit, units)]
    fitting = (name for name, own in _UNITS.items() if parse_unit(own).exponents == dimensions[1])
    quantity = next(fitting, "")
    require(dimensions[0] == parse_unit("s").exponents, f"the unit {units[0]!r} is not one of time")
    require(bool(quantity), f"the second column is a voltage or a position, not in {units[1]!r}")
    is_finite = np.isfinite(columns[0]) & np.isfinite(columns[1])
    require(bool(is_finite.all()), "needs finite numbers", int(np.argmin(is_finite)))
    for column, unit in enumerate(units):
        if parse_unit(unit).factor != 1:
            numbers = columns[column].tolist()
            columns[column] = np.array([parse_si(f"{number!r} {unit}") for number in numbers])
    times, values = columns[0] + 0.0, columns[1] + 0.0  # no zero is negative
    is_rising = np.diff(times, prepend=min(times[0], 0.0) - 1.0) > 0.0
    is_rising[0] &= times[0] <= 0.0
    row = int(np.argmin(is_rising))
    message = f"times rise strictly, from zero or less; found {times[row]:g} s"
    require(bool(is_rising.all()), message, row)
    return HeldRows(quantity, times, values)


@lru_cache(maxsize=64)
def digest(text: str) -> str:
    """What a held text is, without its name: ``sha256:…``."""
    contents = text.partition("\n")[2]
    return f"sha256:{hashlib.sha256(contents.encode()).hexdigest()}"


def without_contents(data: Any) -> Any:
    """Plain data with every held CSV text replaced by its name, size and digest."""
    if isinstance(data, dict):
        return {key: without_contents(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return type(data)(without_contents(value) for value in data)
    if isinstance(data, str) and data.startswith("# ") and "\ntime [s]," in data:
        name = data.partition("\n")[0].removeprefix("# ")
        n_row = data.count("\n") - 2
        return f"{name} ({n_row} row{'s' if n_row > 1 else ''}, {digest(data)[7:15]})"
    return data


PERIODIC = ("square", "sine")
"""Shapes that repeat themselves after a period."""


class InputConfig(Section):
    """Open-loop drive voltage."""

    shape: Literal["square", "steps", "sine", "csv"] = "square"
    """``square``: +amplitude in the first half of each period, −amplitude in the second (paper). ``steps``:
    seeded pseudo-random levels within ±amplitude, each held for a period. ``sine``: one frequency, 1/period.
    ``csv``: the rows of ``file``, which no amplitude scales."""

    amplitude: Annotated[float, SI("V", usual=("1 mV", "100 V"), symbols="U")] = 2.0
    """Amplitude [V]. Axis ticks of Figure 2; 1 V is admissible."""

    period: Annotated[float, SI("s", above=0, usual=("1 ms", "1 h"), symbols="T")] = 2.0
    """Period [s]. A choice; 0.5, 1, 4 and 5 s are admissible."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of the pseudo-random steps."""

    file: Annotated[str, AfterValidator(input_contents)] | None = None
    """CSV file of the shape ``csv``: two columns, time and voltage (in closed loop: position), with a
    header such as ``time [ms], voltage [V]`` (without one: s and V). Each value holds until the next row's
    time, the last to the end of the record; a time between two Runge-Kutta steps takes effect at the next
    step. Times rise strictly, from zero or less. At most 100,000 rows. The path is relative to the
    experiment file that names it; the contents become part of the configuration, so that results do not
    need the file any more."""

    @model_validator(mode="after")
    def _file_belongs_to_csv(self) -> Self:
        if self.shape == "csv" and self.file is None:
            raise ValueError("shape csv needs a file: input.file names a CSV file")
        if self.shape != "csv" and self.file is not None:
            raise ValueError(f"input.file needs shape csv; shape is {self.shape}")
        return self

    def stated(self) -> dict[str, Any]:
        """The fields that differ from their defaults; a file by the digest of its contents."""
        fields = super().stated()
        return fields if self.file is None else fields | {"file": digest(self.file)}

    @property
    def is_periodic(self) -> bool:
        """Whether the voltage repeats itself after a period."""
        return self.shape in PERIODIC


class ControlConfig(Section):
    """Open loop, or closed loop on the piston position."""

    law: Literal["open", "p", "pi", "pid"] = "open"
    """``open``: the input is the voltage of the valve (paper). ``p``, ``pi``, ``pid``: the input is a
    reference for the position, which a sampled controller tracks through the voltage."""

    feedback: Literal["ideal", "measured"] = "ideal"
    """Position used by the controller. ``ideal``: the true position. ``measured``: what ``position_sensor``
    shows, with gain error, bias, drift, white noise, hum, range and resolution. Lags, delay, filter and
    jitter belong to the record and stay out of the loop. Where controller and record sample at the same
    instant, they read the same position if the sensor has neither lag nor delay and ``measurement`` neither
    filter nor jitter, and its noise is not a density or the controller samples as often as the record."""

    amplitude: Annotated[float, SI("m", usual=usual.POSITION)] = 20e-3
    """Amplitude of the position reference [m]; its shape and period are those of the input. A choice."""

    proportional_gain: Annotated[
        float, SI("V/m", least=0, usual=("0.01 V/m", "1000000 V/m"), symbols="K_p")
    ] = 100.0
    """Gain K_p [V/m]. A choice: a crossover near 1 Hz, well below the hydraulic mode."""

    integral_gain: Annotated[float, SI("V/(m*s)", least=0, usual=("0.01 V/(m*s)", "1e7 V/(m*s)"))] = 100.0
    """Gain K_I of the laws ``pi`` and ``pid`` [V/(m·s)]. A choice. The integral is frozen while the voltage
    is limited and the error would drive it further (anti-windup)."""

    derivative_gain: Annotated[float, SI("V*s/m", least=0, usual=("1e-5 V*s/m", "10000 V*s/m"))] = 0.5
    """Gain K_D of the law ``pid`` [V·s/m]. A choice."""

    sample_time: Annotated[float, SI("s", above=0, usual=("1 µs", "1 s"))] = 2e-3
    """Sampling interval of the controller [s]; the voltage is held in between. A choice."""

    voltage_limit: Annotated[float, SI("V", above=0, usual=usual.VOLTAGE)] = 5.0
    """Largest magnitude of the voltage [V]. A choice."""

    @property
    def is_closed(self) -> bool:
        """Whether a controller drives the valve."""
        return self.law != "open"

    @property
    def is_measured(self) -> bool:
        """Whether a controller reads the sensor of the position."""
        return self.is_closed and self.feedback == "measured"

    @property
    def used_integral_gain(self) -> float:
        """K_I, or 0 where the law has none [V/(m·s)]."""
        return self.integral_gain if self.law in {"pi", "pid"} else 0.0

    @property
    def used_derivative_gain(self) -> float:
        """K_D, or 0 where the law has none [V·s/m]."""
        return self.derivative_gain if self.law == "pid" else 0.0


def is_whole(ratio: float) -> bool:
    """Whether a ratio is an integer from 1 on, up to rounding."""
    return math.isfinite(ratio) and round(ratio) >= 1 and abs(ratio - round(ratio)) < 1e-6


_MOST_SAMPLES, _MOST_STEPS_PER_SAMPLE = 10_000_000, 1_000_000
"""What a record may hold so that it fits into memory."""


class RecordConfig(Section):
    """Integration and sampling of a record."""

    duration: Annotated[float, SI("s", above=0, usual=("10 ms", "24 h"))] = 20.0
    """Length of the record [s]."""

    step: Annotated[float, SI("s", above=0, usual=("0.1 µs", "10 ms"), symbols="h dt")] = 1e-4
    """Runge-Kutta step [s]. Legible as ".1 seconds", read as 0.1 ms: 1 ms is unstable in the friction's
    linear zone."""

    sampling_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "1 MHz"), symbols="f_s fs")] = 500.0
    """Sampling frequency of the record [Hz]. Caption of Figure 2, legible as "5"; 250 Hz is admissible."""

    @model_validator(mode="after")
    def _times_fit_the_step(self) -> Self:
        ratio = self.sampling_frequency * self.step
        if ratio < sys.float_info.min or not is_whole(1.0 / ratio):
            raise ValueError(
                f"the sampling interval 1/sampling_frequency = {1 / self.sampling_frequency:g} s"
                f" is not a multiple of step = {self.step:g} s"
            )
        if not is_whole(self.duration * self.sampling_frequency):
            raise ValueError(f"duration = {self.duration:g} s is not a multiple of the sampling interval")
        if self.n_sample > _MOST_SAMPLES or self.steps_per_sample > _MOST_STEPS_PER_SAMPLE:
            raise ValueError(
                f"{self.n_sample:.3g} samples with {self.steps_per_sample:.3g} steps each are too many;"
                f" at most {_MOST_SAMPLES:g} and {_MOST_STEPS_PER_SAMPLE:g}"
            )
        return self

    @property
    def n_step(self) -> int:
        """Number of Runge-Kutta steps."""
        return self.n_sample * self.steps_per_sample

    @property
    def n_sample(self) -> int:
        """Number of samples t_k = k/f_s, k = 0 … n_sample − 1."""
        return round(self.duration * self.sampling_frequency)

    @property
    def time_axis(self) -> tuple[float, float, float]:
        """Duration [s], step [s] and sampling frequency [Hz]."""
        return self.duration, self.step, self.sampling_frequency

    @property
    def steps_per_sample(self) -> int:
        """Number of Runge-Kutta steps from one sample to the next."""
        return round(1.0 / (self.sampling_frequency * self.step))


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


def require_load_fits(load: LoadConfig, record: RecordConfig) -> None:
    """The levels of a pseudo-random load are held for whole steps."""
    if load.random_force:
        _require_whole_steps("load.random_period", load.random_period, record)


def _require_whole_steps(name: str, time: float, record: RecordConfig) -> None:
    if not is_whole(time / record.step):
        raise ValueError(f"{name} = {time:g} s is not a multiple of record.step = {record.step:g} s")
