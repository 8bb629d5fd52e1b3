"""External inputs of a batch of runs: spools or position references, and load forces."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import chain
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.drive import InputConfig, RecordConfig, parse_rows
from hydrofdi.config.machine import LoadConfig
from hydrofdi.physics.valve import control_flow
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.kernel import advance_spools
from hydrofdi.simulation.lanes import SPOOL_PARAMETERS, SPOOLS, WIDTH, indices, lane_groups, positions_by
from hydrofdi.simulation.sensing import feedback_noise, reading_errors

_spool_of = attrgetter(*SPOOL_PARAMETERS.values())

_STEP_ROUNDING = 1e-6
"""Rounding tolerance in steps: a time this close before a step belongs to that step."""


class Drive(NamedTuple):
    """What determines the motion of a spool; runs with equal drives share one spool.

    Attributes
    ----------
    spool : tuple of float
        `SPOOL_PARAMETERS` in SI.
    choices : tuple of (True or None)
        Whether position or speed of the spool saturates, and whether there is hysteresis.
    """

    input: InputConfig
    spool: tuple[float, ...]
    choices: tuple[bool, bool]

    @classmethod
    def of(cls, run: RunParameters) -> Drive:
        """Drive of a run."""
        return cls(run.input, _spool_of(run), (run.valve.is_limited, run.valve.hysteresis > 0.0))


def input_voltage(drive: InputConfig, record: RecordConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Voltage held over the given steps.

    Parameters
    ----------
    record : RecordConfig
        Its step divides half the period of a square wave, and the period of steps.
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        u [V].
    """
    match drive.shape:
        case "square":
            # (u1) in whole steps: time over period would be rounded, and an edge could come a step late.
            half_period = round(drive.period / (2.0 * record.step))
            return np.where((steps // half_period) % 2 == 0, drive.amplitude, -drive.amplitude)
        case "steps":
            return drive.amplitude * random_levels(drive.seed, drive.period, record, steps)
        case "csv":
            return _held_rows(drive, record, steps)
    wave: NDArray[np.float64] = np.sin(2.0 * np.pi * (steps * record.step) / drive.period)
    return drive.amplitude * wave  # (u2)


def position_reference(
    drive: InputConfig, amplitude: float, record: RecordConfig, steps: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Position reference at the given steps, in the shape of an input [m], shape (n,).

    Values from a file are positions and are not scaled by the amplitude.
    """
    return input_voltage(drive.model_copy(update={"amplitude": amplitude}), record, steps)


@lru_cache(maxsize=1024)
def largest_voltage(drive: InputConfig, record: RecordConfig) -> float:
    """Largest possible abs(u) of an input in a record [V]."""
    if drive.shape not in ("steps", "csv"):
        return abs(drive.amplitude)
    return float(np.abs(input_voltage(drive, record, np.arange(record.n_step))).max())


def _held_rows(drive: InputConfig, record: RecordConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    rows = parse_rows(drive.file or "")
    # (u4): a time that is a step but for rounding does not wait for the next step.
    first_steps = np.ceil(rows.times / record.step - _STEP_ROUNDING)
    # The last row that has begun; of rows that begin in the same step, the later one.
    return rows.values[np.searchsorted(first_steps, steps, side="right") - 1]


class Spools:
    """Spools of several drives, advanced together chunk by chunk.

    Parameters
    ----------
    drives : sequence of Drive
        One spool each.
    record : RecordConfig
        Step and length of the record.

    Attributes
    ----------
    columns : ndarray of int, shape (n_drive,)
        Column of each drive in the arrays that `advance` returns.
    """

    def __init__(self, drives: Sequence[Drive], record: RecordConfig) -> None:
        self._record = record
        self._groups = list(lane_groups(drive.choices for drive in drives))
        order = [k for _, group in self._groups for k in group]
        # The inverse of the order by groups.
        self.columns = np.argsort(order)
        self._inputs = [drives[k].input for k in order]
        self._stages = np.empty((0, 4, len(order)))
        self._spools = np.zeros(len(self._groups), SPOOLS)
        for spool, (_, group) in zip(self._spools, self._groups, strict=True):
            for index, field in enumerate(SPOOL_PARAMETERS):
                # Unused spools repeat the others: a gain of zero would be divided by.
                spool[field] = np.resize([drives[k].spool[index] for k in group], WIDTH)

    def advance(self, first: int, n_step: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Advance all spools from step `first` on.

        Returns
        -------
        voltage : ndarray, shape (n_step, n_drive)
            Input of each step [V].
        stages : ndarray, shape (n_step, 4, n_drive)
            Spool position at the four Runge-Kutta stages of each step [m]; valid until the next call.
        """
        steps = np.arange(first, first + n_step)
        distinct = {drive: input_voltage(drive, self._record, steps) for drive in {*self._inputs}}
        voltage = np.empty((n_step, len(self._inputs)))
        for column, drive in enumerate(self._inputs):
            voltage[:, column] = distinct[drive]
        if len(self._stages) < n_step:
            self._stages = np.empty((n_step, 4, voltage.shape[1]))
        stages, first_drive = self._stages[:n_step], 0
        for spool, (choices, group) in enumerate(self._groups):
            advance_spools(
                self._spools[spool : spool + 1], voltage, self._record.step, first_drive, len(group), stages,
                *choices,
            )  # fmt: skip
            first_drive += len(group)
        return voltage, stages


def random_levels(
    seed: int | Sequence[int], period: float, record: RecordConfig, steps: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Levels at the given steps.

    Parameters
    ----------
    period : float
        Holding time of a level, a multiple of the step [s].
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        Levels, uniformly distributed in −1 … 1 [-].
    """
    hold = round(period / record.step)
    # All levels of the record each time, so that they do not depend on where a chunk begins.
    levels = np.random.default_rng(seed).uniform(-1.0, 1.0, -(-record.n_step // hold))
    return levels[steps // hold]


def no_load_flow(parameters: RunParameters, opening: float | None = None) -> float:
    """Control flow without load at a given opening [m], by default the largest [m³/s].

    With equal areas at equal chamber pressures; with unequal ones a bound, as if all of the supply drove it.
    """
    valve, supply = parameters.valve, parameters.supply
    gain = max(edge.flow_gain for edge in parameters.edges)
    # With equal areas both open edges take half of the drop each.
    share = 0.5 if parameters.actuator.area_2 == parameters.actuator.piston_area else 1.0
    drop = share * (supply.pressure - supply.return_pressure)
    most = largest_opening(parameters) if opening is None else opening
    # Factor 1 + g y of (7d) at the largest opening.
    gain *= 1.0 + max(valve.gain_slope, 0.0) * most
    return float(control_flow(most, drop, gain, valve.area_gradient))


def largest_leakage_flows(runs: Sequence[RunParameters], trajectory: Trajectory) -> NDArray[np.float64]:
    """Upper bound of the mean leakage flow of a record, shape (n_run,) [m³/s].

    By continuity, it is the no-load flow at the mean opening plus the flow displaced by the piston.
    """
    openings = np.mean(np.abs(trajectory.spool_position), axis=1)
    speeds = np.mean(np.abs(trajectory.piston_velocity), axis=1)
    return np.array([
        no_load_flow(run, opening + run.largest_opening_at_rest) + max(run.actuator.areas) * speed
        for run, opening, speed in zip(runs, openings, speeds, strict=True)
    ])  # fmt: skip


def no_load_speed(parameters: RunParameters) -> float:
    """No-load speed of the piston [m/s]; with unequal areas a bound of both directions."""
    return no_load_flow(parameters) / min(parameters.actuator.areas)


def largest_opening(parameters: RunParameters) -> float:
    """Largest edge opening that input or controller can command [m]."""
    return largest_travel(parameters) + parameters.largest_opening_at_rest


def largest_travel(parameters: RunParameters) -> float:
    """Largest spool position that input or controller can command [m]."""
    control, valve = parameters.control, parameters.valve
    voltage = control.voltage_limit
    if not control.is_closed:
        voltage = largest_voltage(parameters.input, parameters.record)
    return min(valve.spool_gain * voltage, valve.position_limit)


Array = NDArray[np.float64]


class InputChunk(NamedTuple):
    """Inputs of some steps; runs with equal inputs share a column.

    Attributes
    ----------
    voltage : ndarray, shape (n_step, n_drive)
        Input of the spools in open loop [V].
    stages : ndarray, shape (n_step, 4, n_drive)
        Positions of the spools in open loop [m]; valid until the next chunk.
    references : ndarray, shape (n_step, 2, n_reference)
        Position references of the runs in closed loop, and the errors of the measured positions [m].
    loads : ndarray, shape (n_step, n_load)
        Load forces [N].
    """

    voltage: Array
    stages: Array
    references: Array
    loads: Array

    def part(self, steps: slice) -> InputChunk:
        """Inputs of some of the steps."""
        return InputChunk(*(values[steps] for values in self))


class Inputs:
    """Inputs of a batch of runs.

    Parameters
    ----------
    record : RecordConfig
        Step and length of their record.
    reads_noise : bool
        Whether the positions that controllers read have the noise of their sensors.

    Attributes
    ----------
    n_drive : int
        Number of spools in open loop.
    column_of_run, load_of_run : ndarray of int, shape (n_run,)
        Column of each run in the drives or references, and in the loads.
    """

    def __init__(
        self, runs: Sequence[RunParameters], record: RecordConfig, *, reads_noise: bool = False
    ) -> None:
        self._record = record
        loads = positions_by(run.load for run in runs)
        self._loads, self.load_of_run = list(loads), indices(loads, len(runs))
        # Runs share a reference, unless the errors of a sensor make it their own.
        drives = positions_by(
            (run.input, run.control.amplitude, k if run.control.is_measured else -1)
            if run.control.is_closed
            else Drive.of(run)
            for k, run in enumerate(runs)
        )
        spools = {key: members for key, members in drives.items() if isinstance(key, Drive)}
        references = [members for key, members in drives.items() if key not in spools]
        self._spools, self.n_drive = Spools(list(spools), record), len(spools)
        self._shared = (
            _whole_record(*spools, record)
            if len(spools) == 1 and record.n_step <= _MOST_SHARED_STEPS
            else None
        )
        self.column_of_run = np.empty(len(runs), dtype=int)
        columns = zip(self._spools.columns, spools.values(), strict=True)
        for column, members in chain(columns, enumerate(references)):
            self.column_of_run[members] = column
        first_runs = [runs[members[0]] for members in references]
        self._references = [(run, feedback_noise(run) if reads_noise else None) for run in first_runs]

    def advance(self, first: int, n_step: int) -> InputChunk:
        """Inputs from step `first` on."""
        steps = np.arange(first, first + n_step)
        if self._shared:
            voltage, stages = (values[first : first + n_step] for values in self._shared)
        else:
            voltage, stages = self._spools.advance(first, n_step)
        references = np.zeros((n_step, 2, len(self._references)))
        for column, (run, noise) in enumerate(self._references):
            amplitude = run.control.amplitude
            references[:, 0, column] = position_reference(run.input, amplitude, self._record, steps)
            references[:, 1, column] = reading_errors(run, steps, noise)
        loads = np.column_stack([load_force(load, self._record, steps) for load in self._loads])
        return InputChunk(voltage, stages, references, loads)


_MOST_SHARED_STEPS = 500_000
"""Steps of the longest record whose drive is kept; it takes 20 MB."""


@lru_cache(maxsize=1)
def _whole_record(drive: Drive, record: RecordConfig) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Voltage and stages of one drive over a record, computed once for all batches of a sweep."""
    return Spools([drive], record).advance(0, record.n_step)


_STREAM = 1
"""Random stream of the load, independent of an input with the same seed."""


def load_force(load: LoadConfig, record: RecordConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Force against positive motion at the given steps.

    Parameters
    ----------
    record : RecordConfig
        Its step divides the period of a pseudo-random force.
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        F_L [N].
    """
    if not load.random_force:
        return np.full(steps.shape, load.constant_force)
    seed, period = (load.seed, _STREAM), load.random_period
    levels = random_levels(seed, period, record, steps)
    if load.random_change:
        hold = round(period / record.step)
        before = random_levels(seed, period, record, np.maximum(steps - hold, 0))
        levels = before + np.minimum(steps % hold * record.step / load.random_change, 1.0) * (levels - before)
    return load.constant_force + load.random_force * levels
