"""Simulation of runs whose plant is an FMU, one after the other; what is right of the record is unchanged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.plant import OUTPUTS
from hydrofdi.errors import ConfigError
from hydrofdi.fmi.instance import Instance, PlantError, instance_of
from hydrofdi.physics.control import converted, pid_step
from hydrofdi.simulation.balances import Outcome, Trajectory
from hydrofdi.simulation.inputs import (
    Tap,
    input_voltage,
    load_force,
    position_reference,
    reading_errors,
    steps_per_control,
)

Signals = dict[str, NDArray[np.float64]]
"""Name of a signal → its values at every communication point, shape (n_step,)."""


def simulate_foreign(
    runs: Sequence[RunParameters], leakage_coefficients: Sequence[float], tap: Tap | None = None
) -> Trajectory:
    """Simulate runs on their FMUs; the arguments are those of `simulate_batch`.

    Signals that an FMU does not give are NaN. A run that the FMU ends has the outcome ``plant_failed``.
    """
    record = runs[0].record
    every = slice(None, None, record.steps_per_sample)
    names = (*OUTPUTS, "input_voltage", "reference_position", "load_force")
    rows = {name: np.full((len(runs), record.n_sample), np.nan) for name in names}
    outcomes = []
    for k, (run, coefficient) in enumerate(zip(runs, leakage_coefficients, strict=True)):
        noise = tap.feedback_noise(k) if tap else None
        signals, outcome = _simulated(run, coefficient, noise)
        outcomes.append(outcome)
        for name, values in signals.items():
            rows[name][k] = values[every]
        if tap and tap.wants(k) and outcome.is_ok:
            # Read in one stretch; lanes of the kernel are columns here.
            tap.reader([k])(0, lambda name, signals=signals: _steps(signals, name, record.n_step))  # type: ignore[misc]
    nothing = np.zeros((len(runs), record.n_sample))
    return Trajectory(
        time=np.arange(record.n_sample) / record.sampling_frequency,
        bristle_deflection=nothing,
        hidden_states=np.zeros((len(runs), 0, record.n_sample)),
        leakage_coefficient=np.array(leakage_coefficients, dtype=float),
        outcomes=tuple(outcomes),
        **rows,
    )


def _steps(signals: Signals, name: str, n_step: int) -> NDArray[np.float64]:
    return signals.get(name, np.full(n_step, np.nan))[:, None]


def _simulated(
    run: RunParameters, coefficient: float, noise: NDArray[np.float64] | None
) -> tuple[Signals, Outcome]:
    """Signals of a run, NaN after its end if it ended early."""
    plant = run.plant
    if plant.model is None:
        raise ConfigError(f"{plant.name}: is named by results only; run the experiment file that names the FMU")
    instance = instance_of(plant.model.path, plant.digest)
    values = {name: plant.model.variables[name].own(value) for name, value in plant.own.items()}
    for parameter, name in plant.parameters.items():
        values[name] = plant.model.variables[name].own(run.value(parameter))
    if plant.leakage.coefficient is not None:
        values[plant.leakage.coefficient] = plant.model.variables[plant.leakage.coefficient].own(coefficient)
    signals = _drives(run)
    try:
        _advance(instance, run, values, signals, noise)
    except PlantError as error:
        first = signals["chamber_1_pressure"]
        time = run.record.step * int(np.isfinite(first).sum())
        return signals, Outcome("plant_failed", f"{plant.name} at t = {time:g} s: {error}")
    given = [signals[name] for name in plant.outputs]
    if not all(np.isfinite(values).all() for values in given):
        return signals, Outcome("diverged", f"{plant.name} gives values that are not finite")
    return signals, Outcome()


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
    drives = [(signals[signal], plant.variable(signal)) for signal in plant.inputs]
    given = [(signals[signal], plant.variable(signal)) for signal in plant.outputs]
    controller = _controller(run, noise) if "input_voltage" in plant.inputs and run.control.is_closed else None
    own_drives = [(column - each.offset) / each.factor for column, each in drives]
    first = {each.name: 0.0 if np.isnan(own[0]) else own[0] for own, (_, each) in zip(own_drives, drives, strict=True)}
    instance.start(values, first, record.duration)
    set_inputs = instance.setter([each.name for _, each in drives])
    outputs, step = instance.getter([each.name for _, each in given]), instance.step
    rows = np.full((record.n_step, len(given)), np.nan)
    try:
        if controller is None:
            held = np.column_stack(own_drives) if drives else np.empty((record.n_step, 0))
            changes = np.concatenate([[True], np.any(np.diff(held, axis=0) != 0.0, axis=1)])
            for k in range(record.n_step):
                if changes[k]:
                    set_inputs(held[k])
                rows[k] = outputs()
                step(k * record.step, record.step)
        else:
            place = [*plant.outputs].index("piston_position")
            position = plant.variable("piston_position")
            voltage_place = [*plant.inputs].index("input_voltage")
            voltage = plant.variable("input_voltage")
            inputs = [float(own[0]) for own in own_drives]
            for k in range(record.n_step):
                rows[k] = outputs()
                u = controller(k, position.factor * rows[k, place] + position.offset)
                signals["input_voltage"][k] = u
                inputs = [own[k] for own in own_drives]
                inputs[voltage_place] = (u - voltage.offset) / voltage.factor
                set_inputs(inputs)
                step(k * record.step, record.step)
    except Exception as error:
        raise instance.failed(error) from None
    else:
        instance.end()
    finally:
        for (column, each), own in zip(given, rows.T, strict=True):
            column[:] = each.factor * own + each.offset


def _controller(run: RunParameters, noise: NDArray[np.float64] | None) -> Callable[[int, float], float]:
    """Function from a step and the piston position [m] to the voltage [V], which is held between samples."""
    control, sensor, record = run.control, run.position_sensor, run.record
    steps, due = np.arange(record.n_step), steps_per_control(run)
    references = position_reference(run.input, control.amplitude, record, steps)
    errors = reading_errors(run, steps, noise)
    voltage = integral = previous = 0.0

    def sampled(step: int, position: float) -> float:
        nonlocal voltage, integral, previous
        if step % due == 0:
            if control.is_measured:
                shown = sensor.gain * position + errors[step]  # (m4), then (m5) and (m6)
                position = converted(shown, sensor.lower_end, sensor.upper_end, sensor.resolution)
            error = references[step] - position
            voltage, integral = map(float, pid_step(  # (c1)
                error, previous, integral, control.proportional_gain, control.used_integral_gain,
                control.used_derivative_gain, control.sample_time, control.voltage_limit,
            ))  # fmt: skip
            previous = error
        return voltage

    return sampled
