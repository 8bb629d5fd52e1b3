"""Simulation of runs whose plant is an FMU. It is foreign code, and so never runs in the user's own process:
a crash costs a worker.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import own_cache
from hydrofdi.config import RunParameters
from hydrofdi.config.plant import OUTPUTS
from hydrofdi.engine import TIME_LIMIT, LocalPoolEngine, available_cores
from hydrofdi.errors import ConfigError
from hydrofdi.fmi import Instance, PlantError, instance_of
from hydrofdi.simulation.balances import RunOutcome, Trajectory
from hydrofdi.simulation.inputs import input_voltage, load_force, position_reference
from hydrofdi.simulation.kernel import control as sample_controller
from hydrofdi.simulation.lanes import ModelOptions, pack_singles
from hydrofdi.simulation.sensing import Measurement, feedback_noise, reading_errors, steps_per_control

Signals = dict[str, NDArray[np.float64]]
"""Name of a signal → its values at communication points."""


@dataclass(frozen=True)
class Asked:
    """A run, its K_i, the noise in its loop, and whether every step is wanted in place of the samples."""

    run: RunParameters
    coefficient: float
    noise: NDArray[np.float64] | None
    every_step: bool


def simulate_foreign(
    runs: Sequence[RunParameters], leakage_coefficients: Sequence[float], tap: Measurement | None = None
) -> Trajectory:
    """Simulate runs on their FMUs; the arguments are those of `simulate_batch`.

    Signals that an FMU does not give are NaN. A run that the FMU ends has the outcome ``plant_failed``, one
    that takes its process with it ``killed``.
    """
    record, asked = runs[0].record, []
    for k, (run, coefficient) in enumerate(zip(runs, leakage_coefficients, strict=True)):
        noise, every_step = (feedback_noise(run), tap.wants(k)) if tap else (None, False)
        asked.append(Asked(run, coefficient, noise, every_step))
    names = (*OUTPUTS, "input_voltage", "reference_position", "load_force")
    rows = {name: np.full((len(runs), record.n_sample), np.nan) for name in names}
    outcomes = []
    for k, (signals, outcome) in enumerate(_results(asked)):
        outcomes.append(outcome)
        sampled = slice(None, None, record.steps_per_sample if asked[k].every_step else 1)
        for name, values in signals.items():
            rows[name][k] = values[sampled]
        if tap and asked[k].every_step and signals:
            tap.reader([k])(0, partial(_lane, signals, record.n_step))
    return Trajectory(
        time=np.arange(record.n_sample) / record.sampling_frequency,
        bristle_deflection=np.zeros((len(runs), record.n_sample)),
        hidden_states=np.zeros((len(runs), 0, record.n_sample)),
        leakage_coefficient=np.array(leakage_coefficients, dtype=float),
        outcomes=tuple(outcomes),
        **rows,
    )


def _lane(signals: Signals, n_step: int, name: str) -> NDArray[np.float64]:
    """A signal as a lane of the kernel shows it, shape (n_step, 1)."""
    return signals.get(name, np.full(n_step, np.nan))[:, None]


@cache
def _workers() -> LocalPoolEngine:
    """Processes for FMUs, which end with this one."""
    return LocalPoolEngine(available_cores()).__enter__()


def _results(asked: Sequence[Asked]) -> Iterator[tuple[Signals, RunOutcome]]:
    """Signals and outcome of each run, in order; a worker computes them itself."""
    if multiprocessing.parent_process() is not None:
        yield from map(simulated, asked)
        return
    engine = _workers()
    results: dict[int, tuple[Signals, RunOutcome]] = {}
    for task in asked:
        engine.submit(simulated, task, TIME_LIMIT.get())
    for result in engine.completed():
        if result.failure is None:
            results[id(result.item)] = result.value
        elif result.failure.status in ("killed", "timeout"):
            results[id(result.item)] = {}, RunOutcome(result.failure.status, result.failure.message)
        else:
            engine.cancel()
            raise result.failure.error or RuntimeError(result.failure.message)
    yield from (results[id(task)] for task in asked)


def simulated(asked: Asked) -> tuple[Signals, RunOutcome]:
    """Signals of a run, NaN after its end if it ended early."""
    run, plant = asked.run, asked.run.plant
    if plant.model is None:
        raise ConfigError(
            f"{plant.name}: is named by results only: give its experiment, to 'rerun' with --config"
        )
    instance = instance_of(plant.model.path, plant.digest, own_cache("fmus"))
    variables = plant.model.variables
    given = plant.own | {name: run.value(parameter) for parameter, name in plant.parameters.items()}
    if plant.leakage.coefficient is not None:
        given[plant.leakage.coefficient] = asked.coefficient
    values = {name: variables[name].own(value) for name, value in given.items()}
    signals, outcome = _drives(run), RunOutcome()
    try:
        _advance(instance, run, values, signals, asked.noise)
    except PlantError as error:
        time = run.record.step * int(np.isfinite(signals["chamber_1_pressure"]).sum())
        outcome = RunOutcome("plant_failed", f"{plant.name} at t = {time:g} s: {error}")
    else:
        if not all(np.isfinite(signals[name]).all() for name in plant.outputs):
            outcome = RunOutcome("plant_failed", f"{plant.name} gives values that are not finite")
    sampled = slice(None, None, 1 if asked.every_step else run.record.steps_per_sample)
    return {name: values[sampled] for name, values in signals.items()}, outcome


def _drives(run: RunParameters) -> Signals:
    """What drives a run, and empty outputs."""
    record = run.record
    steps = np.arange(record.n_step)
    nothing = np.full(record.n_step, np.nan)
    signals = {name: nothing.copy() for name in run.plant.outputs} | {
        "input_voltage": nothing,
        "reference_position": nothing,
        "load_force": load_force(run.load, record, steps),
    }
    if run.control.is_closed:
        signals["reference_position"] = position_reference(run.input, run.control.amplitude, record, steps)
        if "reference_position" not in run.plant.inputs:
            signals["input_voltage"] = nothing.copy()  # the controller fills it
    else:
        signals["input_voltage"] = input_voltage(run.input, record, steps)
    return signals


def _advance(
    instance: Instance,
    run: RunParameters,
    values: dict[str, Any],
    signals: Signals,
    noise: NDArray[np.float64] | None,
) -> None:
    """Run an FMU over a record; the outputs are filled as far as it goes."""
    plant, record = run.plant, run.record
    drives = [plant.variable(signal) for signal in plant.inputs]
    given = [plant.variable(signal) for signal in plant.outputs]
    held = np.column_stack([
        (signals[signal] - variable.offset) / variable.factor
        for signal, variable in zip(plant.inputs, drives, strict=True)
    ])  # fmt: skip
    first = {variable.name: value for variable, value in zip(drives, np.nan_to_num(held[0]), strict=True)}
    instance.start(values, first, record.duration)
    set_inputs = instance.setter([variable.name for variable in drives])
    outputs, step = instance.getter([variable.name for variable in given]), instance.step
    rows = np.full((record.n_step, len(given)), np.nan)
    control = _controller(run, noise, signals["input_voltage"], held)
    try:
        for k in range(record.n_step):
            # The sample at a time has the inputs of the step that begins there, as in the kernel.
            rows[k] = outputs()
            if control is not None:
                control(k, rows[k])
            if k == 0 or (held[k] != held[k - 1]).any():
                set_inputs(held[k])
            if k + 1 < record.n_step:  # nothing is read after the last sample
                step(k * record.step, record.step)
    except Exception as error:
        raise instance.failed(error) from None
    else:
        instance.end()
    finally:
        for signal, variable, own in zip(plant.outputs, given, rows.T, strict=True):
            signals[signal][:] = variable.factor * own + variable.offset


def _controller(
    run: RunParameters,
    noise: NDArray[np.float64] | None,
    voltages: NDArray[np.float64],
    held: NDArray[np.float64],
) -> Callable[[int, NDArray[np.float64]], None] | None:
    """Function that, given a step and the outputs there, sets voltage [V] and inputs of that step.

    None in open loop, or if the FMU has the controller.
    """
    record, plant, due = run.record, run.plant, steps_per_control(run)
    if not run.control.is_closed or "input_voltage" not in plant.inputs:
        return None
    steps, options = np.arange(record.n_step), ModelOptions.of(run)
    wanted = position_reference(run.input, run.control.amplitude, record, steps)
    references = np.stack([wanted, reading_errors(run, steps, noise)])
    parameters = pack_singles([run], [0.0])[0]
    lane = SimpleNamespace(
        **{name: parameters[name] for name in parameters.dtype.names},
        **{name: np.zeros(1) for name in ("position", "voltage", "integral", "error")},
    )
    column, output = list(plant.inputs).index("input_voltage"), list(plant.outputs).index("piston_position")
    drive, shown = plant.variable("input_voltage"), plant.variable("piston_position")

    def sampled(step: int, outputs: NDArray[np.float64]) -> None:
        if step % due == 0:
            lane.position[0] = shown.factor * outputs[output] + shown.offset
            sample_controller(lane, 0, references, step, options)
        voltages[step] = lane.voltage[0]
        held[step, column] = (voltages[step] - drive.offset) / drive.factor

    return sampled
