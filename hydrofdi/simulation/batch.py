"""Simulation of a batch of runs in lanes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.drive import RecordConfig
from hydrofdi.config.machine import ActuatorConfig
from hydrofdi.simulation.balances import Outcome, Signal, Trajectory
from hydrofdi.simulation.inputs import Chunk, Inputs, Reader, Tap, steps_per_control
from hydrofdi.simulation.kernels.hydraulics import lane_parameters, leakage_of
from hydrofdi.simulation.kernels.kernel import advance_lanes
from hydrofdi.simulation.kernels.lanes import (
    HIDDEN,
    N_PAPER_SAMPLED,
    SAMPLED,
    WIDTH,
    ModelOptions,
    pack_lanes,
    pack_singles,
    positions_by,
)

_CHUNK_STEPS, _CHUNK_SPOOL_STEPS = 5000, 64_000
"""Approximate number of steps of a chunk, and of spool steps in it, so that a chunk fits the cache."""

_STRETCH_STEPS = 500
"""Number of steps at a time if every step is read, so that they fit the cache."""

ABSURD_PRESSURE_RATIO = 100.0
"""Ratio of pressure to supply pressure above which a run has diverged, even if it is finite."""

_CLOSE_TO_STOP = 0.98
"""Fraction of V/A beyond which the piston has left a cylinder without a stated stroke: a chamber volume is
nearly zero."""


ROWS = {
    "piston_position": "position",
    "piston_velocity": "velocity",
    "chamber_1_pressure": "pressure_1",
    "chamber_2_pressure": "pressure_2",
    "valve_supply_pressure": "supply",
    "line_1_pressure": "line_pressure_1",
    "line_2_pressure": "line_pressure_2",
    "input_voltage": "voltage",
    "spool_position": "spool_position",
}
"""Signal of a trajectory → its row in the samples."""


def simulate_batch(
    runs: Sequence[RunParameters], leakage_coefficients: Sequence[float], tap: Tap | None = None
) -> Trajectory:
    """Simulate runs in parallel lanes. The signals of a run do not depend on the others.

    Parameters
    ----------
    runs : sequence of RunParameters
        At least one; all with the same ``run`` section. Their own leakage settings are ignored.
    leakage_coefficients : sequence of float
        K_i of each run [m^3.5/kg^0.5].
    tap : Tap, optional
        Reads some of the runs at every step, at no cost for the others. It does not change signals, except by
        the noise that controllers read (``control.feedback``).

    Returns
    -------
    Trajectory
        Includes failed runs, marked by their outcome.

    Raises
    ------
    ValueError
        There are no runs, or their duration, step or sampling differs.
    """
    if len({parameters.record.time_axis for parameters in runs}) != 1:
        raise ValueError("the runs of a batch must share duration, step and sampling frequency")
    if runs[0].plant.fmu is not None:
        from hydrofdi.simulation.foreign import simulate_foreign  # only an experiment with an FMU loads FMPy

        return simulate_foreign(runs, leakage_coefficients, tap)
    inputs = Inputs(runs, runs[0].record, tap)
    kernels = ((ModelOptions.of(run), steps_per_control(run) if run.control.is_closed else 1) for run in runs)
    blocks = [
        _Block(options, control_interval, members, runs, leakage_coefficients, inputs, reader)
        for (options, control_interval), group in positions_by(kernels).items()
        for members, reader in _members_of_blocks(group, tap)
    ]
    signals = _Signals(runs, inputs)
    for window, chunk in chunks(inputs, runs[0].record):
        for block in blocks:
            samples = block.advance(chunk, window.start)
            signals.keep(block, window, chunk, samples)
    return signals.trajectory(leakage_coefficients)


def _members_of_blocks(group: list[int], tap: Tap | None) -> Iterator[tuple[list[int], Reader | None]]:
    """Members of each block of a group of runs, and their reader if every step is read."""
    read = {k for k in group if tap.wants(k)} if tap else set()
    for members in _up_to_width([k for k in group if k not in read]):
        yield members, None
    if tap:
        for members in _up_to_width(sorted(read)):
            yield members, tap.reader(members)


def _up_to_width(positions: list[int]) -> Iterator[list[int]]:
    for first in range(0, len(positions), WIDTH):
        yield positions[first : first + WIDTH]


def chunks(inputs: Inputs, record: RecordConfig) -> Iterator[tuple[slice, Chunk]]:
    """Windows of samples of the record, and the inputs of their steps."""
    most = min(_CHUNK_STEPS, _CHUNK_SPOOL_STEPS // max(inputs.n_drive, 1))
    length = max(1, most // record.steps_per_sample)
    for first in range(0, record.n_sample, length):
        window = slice(first, min(first + length, record.n_sample))
        steps = (window.stop - window.start) * record.steps_per_sample
        yield window, inputs.advance(first * record.steps_per_sample, steps)


class _Block:
    """Up to WIDTH runs of a batch with the same options, in lanes."""

    def __init__(
        self,
        options: ModelOptions,
        steps_per_control: int,
        members: list[int],
        runs: Sequence[RunParameters],
        leakage_coefficients: Sequence[float],
        inputs: Inputs,
        reader: Reader | None,
    ) -> None:
        self.options, self.members = options, members
        self.columns, self.loads = inputs.column_of_run[members], inputs.load_of_run[members]
        self._runs = [runs[k] for k in members]
        self._record, self._steps_per_control = self._runs[0].record, steps_per_control
        self._lanes = pack_lanes(self._runs, [leakage_coefficients[k] for k in members])
        self._column_of_lane, self._load_of_lane = (
            np.resize(self.columns, WIDTH),
            np.resize(self.loads, WIDTH),
        )
        self._shares_drive = int(len(set(self.columns.tolist())) == 1)
        self._n_row = len(SAMPLED) if options.samples_more else N_PAPER_SAMPLED
        self._reader, self._rated_supply = (
            reader,
            np.resize([runs[k].supply.pressure for k in members], WIDTH),
        )

    def advance(self, chunk: Chunk, first_sample: int) -> NDArray[np.float64]:
        """Samples (n_sample, n_row, WIDTH) over a chunk."""
        first_step, per_sample = first_sample * self._record.steps_per_sample, self._record.steps_per_sample
        if self._reader is None:
            return self._samples(chunk, first_step, per_sample)
        samples = np.empty((len(chunk.loads) // per_sample, self._n_row, WIDTH))
        for first in range(0, len(chunk.loads), _STRETCH_STEPS):
            stretch = chunk.part(first, first + _STRETCH_STEPS)
            states = self._samples(stretch, first_step + first, 1)
            self._reader(first_step + first, partial(self._signal, stretch, states, first_step + first))
            # From the first sample at or after the start; a stretch need not begin with one.
            samples[-(-first // per_sample) : -(-(first + len(states)) // per_sample)] = states[
                -first % per_sample :: per_sample
            ]
        return samples

    def _samples(self, chunk: Chunk, first_step: int, steps_per_sample: int) -> NDArray[np.float64]:
        drive = chunk.references if self.options.closed_loop else chunk.stages
        samples = np.empty((len(drive) // steps_per_sample, self._n_row, WIDTH))
        advance_lanes(
            self._lanes, drive, self._column_of_lane, chunk.loads, self._load_of_lane,
            self._shares_drive, self._record.step, steps_per_sample, self._steps_per_control, samples,
            first_step, self.options,
        )  # fmt: skip
        return samples

    def _signal(
        self, chunk: Chunk, states: NDArray[np.float64], first_step: int, name: str
    ) -> NDArray[np.float64]:
        """A signal at every step of a chunk, by its name in a trajectory: shape (n_step, WIDTH)."""
        if name == "oil_temperature":
            time = self._record.step * np.arange(first_step, first_step + len(states), dtype=np.float64)
            return np.column_stack([run.fluid.temperature_at(time) for run in self._runs])
        if not self.options.closed_loop and name == "input_voltage":
            return chunk.voltage[:, self._column_of_lane]
        if not self.options.closed_loop and name == "spool_position":
            return chunk.stages[:, 0, self._column_of_lane]
        if not self.options.moving_supply and name == "valve_supply_pressure":
            return np.broadcast_to(self._rated_supply, (len(states), WIDTH))
        return states[:, SAMPLED.index(ROWS[name])]


_SUPPORT = list(HIDDEN).index("support")


class _Signals:
    """The sampled signals of a batch, filled window by window."""

    def __init__(self, runs: Sequence[RunParameters], inputs: Inputs) -> None:
        self._runs = runs
        shape = len(runs), runs[0].record.n_sample
        options = [ModelOptions.of(run) for run in runs]
        self._states = np.empty((N_PAPER_SAMPLED, *shape))
        self._voltage, self._spool = np.empty((2, *shape))
        supply = np.array([run.supply.pressure for run in runs])
        self._supply = _held(supply, any(o.moving_supply for o in options), shape)
        self._bristle = _held(np.zeros(len(runs)), any(o.bristles for o in options), shape)
        hides = any(getattr(o, option) for o in options for option in HIDDEN.values())
        self._hidden = np.zeros((shape[0], hides * len(HIDDEN), shape[1]))
        self._load = _held(np.zeros(len(runs)), any(o.load_force for o in options), shape)
        self._reference = _held(np.full(len(runs), np.nan), bool(inputs.is_closed.any()), shape)

    def keep(self, block: _Block, window: slice, chunk: Chunk, samples: NDArray[np.float64]) -> None:
        """Store the samples of a block."""
        members, options = block.members, block.options
        rows = samples[:, :, : len(members)].transpose(1, 2, 0)
        every = slice(None, None, self._runs[0].record.steps_per_sample)
        self._states[:, members, window] = rows[:N_PAPER_SAMPLED]
        if options.moving_supply:
            self._supply[members, window] = rows[SAMPLED.index("supply")]
        if options.bristles:
            self._bristle[members, window] = rows[SAMPLED.index("bristle")]
        for index, (name, option) in enumerate(HIDDEN.items()):
            if getattr(options, option):
                self._hidden[members, index, window] = rows[SAMPLED.index(name)]
        if options.load_force:
            self._load[members, window] = chunk.loads[every, block.loads].T
        if options.closed_loop:
            self._voltage[members, window] = rows[SAMPLED.index("voltage")]
            self._spool[members, window] = rows[SAMPLED.index("spool_position")]
            self._reference[members, window] = chunk.references[every, 0, block.columns].T
        else:
            self._voltage[members, window] = chunk.voltage[every, block.columns].T
            self._spool[members, window] = chunk.stages[every, 0, block.columns].T

    def trajectory(self, leakage_coefficients: Sequence[float]) -> Trajectory:
        """Trajectory with all signals and derived quantities."""
        record = self._runs[0].record
        position, velocity, pressure_1, pressure_2 = self._states
        time = np.arange(record.n_sample) / record.sampling_frequency
        return Trajectory(
            time=time,
            input_voltage=self._voltage,
            reference_position=self._reference,
            load_force=self._load,
            spool_position=self._spool,
            piston_position=position,
            piston_velocity=velocity,
            chamber_1_pressure=pressure_1,
            chamber_2_pressure=pressure_2,
            valve_supply_pressure=self._supply,
            bristle_deflection=self._bristle,
            hidden_states=self._hidden,
            leakage_coefficient=np.array(leakage_coefficients, dtype=float),
            internal_leakage_flow=leakage_signal(
                self._runs,
                leakage_coefficients,
                time,
                pressure_1 - pressure_2,
                position - self._hidden[:, _SUPPORT] if self._hidden.size else position,
                velocity,
            ),
            outcomes=tuple(outcome_of(run, self._states[:, k]) for k, run in enumerate(self._runs)),
            oil_temperature=oil_temperatures(self._runs, time),
        )


def _held(values: Signal, moves: bool, shape: tuple[int, int]) -> Signal:
    """A constant signal with the given values (n_run,); writable if it varies."""
    held = np.broadcast_to(values[:, None], shape)
    return held.copy() if moves else held


def oil_temperatures(runs: Sequence[RunParameters], time: Signal) -> Signal | None:
    """Temperature of the oil of each run at some times, (n_run, n_time) [K]; None if no run states it."""
    is_stated = any(run.fluid.temperature is not None for run in runs)
    return np.array([run.fluid.temperature_at(time) for run in runs]) if is_stated else None


def outcome_of(parameters: RunParameters, states: NDArray[np.float64]) -> Outcome:
    """Outcome of a run, from its states (4, n_time)."""
    record = parameters.record
    pressure_limit = ABSURD_PRESSURE_RATIO * parameters.supply.pressure
    low, high = _outermost(parameters.actuator)
    with np.errstate(invalid="ignore"):
        # Comparisons with NaN are false, so the pressures alone would not show it.
        diverged = ~np.all(np.isfinite(states), axis=0) | np.any(np.abs(states[2:]) > pressure_limit, axis=0)
        beyond = (states[0] < low) | (states[0] > high)
    # Beyond the stroke a volume vanishes and pressures diverge, so the sample before tells the cause.
    at_the_stop = diverged.any() and bool(beyond[np.argmax(diverged) - 1])
    if diverged.any() and not at_the_stop:
        time = np.argmax(diverged) / record.sampling_frequency
        return Outcome(
            "diverged",
            f"the state grew without bound by t = {time:g} s; the step of {record.step:g} s is too long",
        )
    if beyond.any() or at_the_stop:
        time = np.argmax(beyond | diverged) / record.sampling_frequency
        return Outcome(
            "stroke_exceeded",
            f"the piston left its stroke, {low:.4g} to {high:.4g} m from the centre, at t = {time:g} s",
        )
    return Outcome()


def _outermost(actuator: ActuatorConfig) -> tuple[float, float]:
    """Positions beyond which the piston has left the cylinder [m]; elastic stops may give way."""
    if actuator.stroke is not None and actuator.end_stops == "none":
        return actuator.ends
    low, high = actuator.vanishing
    return _CLOSE_TO_STOP * low, _CLOSE_TO_STOP * high


def leakage_signal(
    runs: Sequence[RunParameters],
    leakage_coefficients: Sequence[float],
    time: NDArray[np.float64],
    pressure_difference: NDArray[np.float64],
    position: NDArray[np.float64],
    velocity: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Internal leakage flow of runs, each with its own law and onset.

    Parameters
    ----------
    leakage_coefficients : sequence of float
        K_i of each run [m^3.5/kg^0.5].
    time : ndarray, shape (n_time,)
        Sampling instants [s].
    pressure_difference, position, velocity : ndarray, shape (n_run, n_time)
        P_1 − P_2 [Pa], x_p [m] and v_p [m/s].

    Returns
    -------
    ndarray, shape (n_run, n_time)
        q_il from chamber 1 to chamber 2 [m³/s].
    """
    singles = pack_singles(runs, leakage_coefficients)
    flow = np.empty_like(pressure_difference)
    for options, members in positions_by(map(ModelOptions.of, runs)).items():
        rows = slice(None) if len(members) == len(runs) else members  # no copies
        columns = singles[rows].view(np.recarray)
        # All runs as lanes: fields (n_run, 1) broadcast with the time (n_time,).
        parameters = lane_parameters(columns, ..., time, time, options)
        flow[rows] = leakage_of(
            pressure_difference[rows], position[rows], velocity[rows], parameters, options
        )
    return flow
