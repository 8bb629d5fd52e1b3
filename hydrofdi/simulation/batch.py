"""Simulation of a batch of runs in lanes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.drive import RecordConfig
from hydrofdi.config.machine import ActuatorConfig
from hydrofdi.simulation.balances import RunOutcome, Signal, Trajectory
from hydrofdi.simulation.hydraulics import lane_parameters, leakage_of
from hydrofdi.simulation.inputs import InputChunk, Inputs
from hydrofdi.simulation.kernel import advance_lanes
from hydrofdi.simulation.lanes import (
    HIDDEN,
    N_PAPER_SAMPLED,
    SAMPLED,
    WIDTH,
    ModelOptions,
    lane_groups,
    pack_lanes,
    pack_singles,
    positions_by,
)
from hydrofdi.simulation.sensing import LaggedRuns, Measurement, steps_per_control

_CHUNK_STEPS, _CHUNK_SPOOL_STEPS = 5000, 64_000
"""Approximate number of steps of a chunk, and of spool steps in it, so that a chunk fits the cache."""

_STRETCH_STEPS = 500
"""Number of steps at a time if every step is read, so that they fit the cache."""

ABSURD_PRESSURE_RATIO = 100.0
"""Ratio of pressure to supply pressure above which a run has diverged, even if it is finite."""

_SUPPORT = list(HIDDEN).index("support")

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
    "bristle_deflection": "bristle",
    "input_voltage": "voltage",
    "spool_position": "spool_position",
    **{name: name for name in HIDDEN},
}
"""Signal of a trajectory → its row in the samples."""

_OPTION_OF = {
    "valve_supply_pressure": "moving_supply",
    "bristle_deflection": "bristles",
    "load_force": "load_force",
    "reference_position": "closed_loop",
    **HIDDEN,
}
"""Signal of a trajectory → the option of the model without which it is constant."""


def simulate_batch(
    runs: Sequence[RunParameters], leakage_coefficients: Sequence[float], tap: Measurement | None = None
) -> Trajectory:
    """Simulate runs in parallel lanes. The signals of a run do not depend on the others.

    Parameters
    ----------
    runs : sequence of RunParameters
        At least one; all with the same ``run`` section. Their own leakage settings are ignored.
    leakage_coefficients : sequence of float
        K_i of each run [m^3.5/kg^0.5].
    tap : Measurement, optional
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
    record, inputs = runs[0].record, Inputs(runs, runs[0].record, reads_noise=tap is not None)
    kernels = (
        (
            ModelOptions.of(run),
            steps_per_control(run) if run.control.is_closed else 1,
            tap is not None and tap.wants(k),
        )
        for k, run in enumerate(runs)
    )
    blocks = [
        _Lanes(options, every, members, runs, leakage_coefficients, inputs, tap if is_read else None)
        for (options, every, is_read), members in lane_groups(kernels)
    ]
    signals = _Signals(runs)
    for window, chunk in chunks(inputs, record):
        sampled = chunk.part(slice(None, None, record.steps_per_sample))
        for block in blocks:
            samples = block.advance(chunk, window.start)
            for name, values in signals.moving.items():
                own = block.signal(sampled, samples, name)[:, : len(block.members)]
                values[block.members, window] = own.T
    return signals.trajectory(leakage_coefficients)


def chunks(inputs: Inputs, record: RecordConfig) -> Iterator[tuple[slice, InputChunk]]:
    """Windows of samples of the record, and the inputs of their steps."""
    most = min(_CHUNK_STEPS, _CHUNK_SPOOL_STEPS // max(inputs.n_drive, 1))
    length = max(1, most // record.steps_per_sample)
    for first in range(0, record.n_sample, length):
        window = slice(first, min(first + length, record.n_sample))
        steps = (window.stop - window.start) * record.steps_per_sample
        yield window, inputs.advance(first * record.steps_per_sample, steps)


class _Lanes:
    """Up to WIDTH runs of a batch with the same options, in lanes."""

    def __init__(
        self,
        options: ModelOptions,
        steps_per_control: int,
        members: list[int],
        runs: Sequence[RunParameters],
        leakage_coefficients: Sequence[float],
        inputs: Inputs,
        tap: Measurement | None,
    ) -> None:
        self.options, self.members = options, members
        self._runs = [runs[k] for k in members]
        self._record, self._steps_per_control = self._runs[0].record, steps_per_control
        self._lanes = pack_lanes(self._runs, [leakage_coefficients[k] for k in members])
        self._column_of_lane = np.resize(inputs.column_of_run[members], WIDTH)
        self._load_of_lane = np.resize(inputs.load_of_run[members], WIDTH)
        self._shares_drive = int(len(set(self._column_of_lane.tolist())) == 1)
        self._n_row = len(SAMPLED) if options.samples_more else N_PAPER_SAMPLED
        self._rated_supply = np.resize([run.supply.pressure for run in self._runs], WIDTH)
        self._reader = tap.reader(members) if tap else None

    def advance(self, chunk: InputChunk, first_sample: int) -> NDArray[np.float64]:
        """Samples (n_sample, n_row, WIDTH) over a chunk."""
        first_step, per_sample = first_sample * self._record.steps_per_sample, self._record.steps_per_sample
        if self._reader is None:
            return self._samples(chunk, first_step, per_sample)
        samples = np.empty((len(chunk.loads) // per_sample, self._n_row, WIDTH))
        for first in range(0, len(chunk.loads), _STRETCH_STEPS):
            stretch = chunk.part(slice(first, first + _STRETCH_STEPS))
            states = self._samples(stretch, first_step + first, 1)
            self._read(self._reader, first_step + first, stretch, states)
            # From the first sample at or after the start; a stretch need not begin with one.
            samples[-(-first // per_sample) : -(-(first + len(states)) // per_sample)] = states[
                -first % per_sample :: per_sample
            ]
        return samples

    def _samples(self, chunk: InputChunk, first_step: int, steps_per_sample: int) -> NDArray[np.float64]:
        drive = chunk.references if self.options.closed_loop else chunk.stages
        samples = np.empty((len(drive) // steps_per_sample, self._n_row, WIDTH))
        advance_lanes(
            self._lanes, drive, self._column_of_lane, chunk.loads, self._load_of_lane,
            self._shares_drive, self._record.step, steps_per_sample, self._steps_per_control, samples,
            first_step, self.options,
        )  # fmt: skip
        return samples

    def _read(
        self, reader: LaggedRuns, first_step: int, chunk: InputChunk, states: NDArray[np.float64]
    ) -> None:
        """Show a reader every step of a chunk."""

        def signal(name: str) -> NDArray[np.float64]:
            if name == "oil_temperature":
                time = self._record.step * np.arange(first_step, first_step + len(states), dtype=np.float64)
                return np.column_stack([run.fluid.temperature_at(time) for run in self._runs])
            return self.signal(chunk, states, name)

        reader(first_step, signal)

    def signal(self, chunk: InputChunk, states: NDArray[np.float64], name: str) -> NDArray[np.float64]:
        """A signal at the steps of a chunk, by its name in a trajectory: shape (n_step, WIDTH)."""
        if name in _OPTION_OF and not getattr(self.options, _OPTION_OF[name]):
            if name == "valve_supply_pressure":
                return np.broadcast_to(self._rated_supply, (len(states), WIDTH))
            return np.full((len(states), WIDTH), np.nan if name == "reference_position" else 0.0)
        if name == "load_force":
            return chunk.loads[:, self._load_of_lane]
        if name == "reference_position":
            return chunk.references[:, 0, self._column_of_lane]
        if not self.options.closed_loop and name == "input_voltage":
            return chunk.voltage[:, self._column_of_lane]
        if not self.options.closed_loop and name == "spool_position":
            return chunk.stages[:, 0, self._column_of_lane]
        return states[:, SAMPLED.index(ROWS[name])]


class _Signals:
    """The sampled signals of a batch; those that move are filled window by window."""

    def __init__(self, runs: Sequence[RunParameters]) -> None:
        self._runs = runs
        shape = len(runs), runs[0].record.n_sample
        options = [ModelOptions.of(run) for run in runs]
        moves = {name: any(getattr(own, option) for own in options) for name, option in _OPTION_OF.items()}
        hidden = np.zeros((shape[0], len(HIDDEN) * any(moves[name] for name in HIDDEN), shape[1]))
        # The states lie together, as `outcome_of` takes them.
        self._states = np.empty((N_PAPER_SAMPLED, *shape))
        moving = dict(zip(ROWS, self._states, strict=False))
        moving |= {name: np.empty(shape) for name in ("input_voltage", "spool_position")}
        constant = {
            "valve_supply_pressure": np.array([run.supply.pressure for run in runs])[:, None],
            "reference_position": np.array(np.nan),
            "bristle_deflection": np.array(0.0),
            "load_force": np.array(0.0),
        }
        whole = {name: np.broadcast_to(values, shape) for name, values in constant.items()}
        moving |= {name: values.copy() for name, values in whole.items() if moves[name]}
        self._signals = whole | moving | {"hidden_states": hidden}
        self.moving = moving | {name: hidden[:, k] for k, name in enumerate(HIDDEN) if moves[name]}

    def trajectory(self, leakage_coefficients: Sequence[float]) -> Trajectory:
        """Trajectory with all signals and derived quantities."""
        record, hidden = self._runs[0].record, self._signals["hidden_states"]
        position, velocity, pressure_1, pressure_2 = self._states
        if hidden.size:
            position = position - hidden[:, _SUPPORT]
        time = np.arange(record.n_sample) / record.sampling_frequency
        return Trajectory(
            time=time,
            leakage_coefficient=np.array(leakage_coefficients, dtype=float),
            internal_leakage_flow=leakage_signal(
                self._runs, leakage_coefficients, time, pressure_1 - pressure_2, position, velocity
            ),
            outcomes=tuple(outcome_of(run, self._states[:, k]) for k, run in enumerate(self._runs)),
            oil_temperature=oil_temperatures(self._runs, time),
            **self._signals,
        )


def oil_temperatures(runs: Sequence[RunParameters], time: Signal) -> Signal | None:
    """Temperature of the oil of each run at some times, (n_run, n_time) [K]; None if no run states it."""
    is_stated = any(run.fluid.temperature is not None for run in runs)
    return np.array([run.fluid.temperature_at(time) for run in runs]) if is_stated else None


def outcome_of(parameters: RunParameters, states: NDArray[np.float64]) -> RunOutcome:
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
        return RunOutcome(
            "diverged",
            f"the state grew without bound by t = {time:g} s; the step of {record.step:g} s is too long",
        )
    if beyond.any() or at_the_stop:
        time = np.argmax(beyond | diverged) / record.sampling_frequency
        return RunOutcome(
            "stroke_exceeded",
            f"the piston left its stroke, {low:.4g} to {high:.4g} m from the centre, at t = {time:g} s",
        )
    return RunOutcome()


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
