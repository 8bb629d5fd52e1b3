"""The equations of the kernel, integrated with SciPy's solvers: an independent check of its runs."""

from collections.abc import Sequence
from functools import partial
from itertools import accumulate, pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import recorded_kernel
from hydrofdi.config import RunParameters
from hydrofdi.physics import valve
from hydrofdi.physics.valve import acting_voltage
from hydrofdi.simulation import hydraulics, inputs, kernel, sensing
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.batch import ROWS, leakage_signal, oil_temperatures, outcome_of
from hydrofdi.simulation.lanes import N_PAPER_SAMPLED, STATES, ModelOptions, pack_singles

Solver = Literal["lsoda", "radau"]

RELATIVE_TOLERANCE = 1e-8

_SCALES = np.array([1e-2, 1e-1, 1e6, 1e6, 1e6, 1e-5, 1e6, 1e-4, 1e6, 1e-5, 1e6, 1e-5, 1e-5, 1e-2])
"""Scales of the hydraulic states [SI], and of x_v [m] and v_v [m/s], for the absolute tolerance."""

_SPOOL = len(STATES)


def simulate_with_solver(
    runs: Sequence[RunParameters],
    leakage_coefficients: Sequence[float],
    solver: Solver,
    tolerance: float = RELATIVE_TOLERANCE,
    tap: sensing.Measurement | None = None,
) -> Trajectory:
    """Simulate runs one by one with a solver of SciPy."""
    sampling = runs[0].record
    singles = pack_singles(runs, leakage_coefficients)
    records = [
        _Record(
            parameters, singles[k : k + 1], solver, tolerance,
            tap.reader([k]) if tap and tap.wants(k) else None,
            sensing.feedback_noise(parameters) if tap else None,
        )
        for k, parameters in enumerate(runs)
    ]  # fmt: skip
    for record in records:
        record.solve()
    states = np.stack([record.states for record in records], axis=1)
    time = np.arange(sampling.n_sample) / sampling.sampling_frequency
    every = slice(None, None, sampling.steps_per_sample)
    return Trajectory(
        time=time,
        input_voltage=np.array([record.voltage[every] for record in records]),
        reference_position=np.array([record.reference[every] for record in records]),
        load_force=np.array([record.load[every] for record in records]),
        spool_position=np.clip(states[_SPOOL], -singles["spool_limit"], singles["spool_limit"]),
        piston_position=states[0],
        piston_velocity=states[1],
        chamber_1_pressure=states[2],
        chamber_2_pressure=states[3],
        valve_supply_pressure=states[4],
        bristle_deflection=states[5],
        hidden_states=states[6:_SPOOL].transpose(1, 0, 2),
        leakage_coefficient=np.array(leakage_coefficients, dtype=float),
        internal_leakage_flow=leakage_signal(
            runs, leakage_coefficients, time, states[2] - states[3], states[0], states[1]
        ),
        outcomes=tuple(
            outcome_of(parameters, states[:N_PAPER_SAMPLED, k]) for k, parameters in enumerate(runs)
        ),
        oil_temperature=oil_temperatures(runs, time),
    )


class _Record:
    """Integration of one run, from jump to jump of its inputs."""

    def __init__(
        self,
        parameters: RunParameters,
        single: NDArray[Any],
        solver: Solver,
        tolerance: float,
        reader: sensing.LaggedRuns | None,
        noise: NDArray[np.float64] | None,
    ) -> None:
        record, supply = parameters.record, parameters.supply
        steps = np.arange(record.n_step)
        self._record, self._single, self._solver, self._tolerance = record, single, solver, tolerance
        self._reader, self._fluid = reader, parameters.fluid
        self._options = ModelOptions.of(parameters)
        self._is_closed = parameters.control.is_closed
        self._steps_per_control = sensing.steps_per_control(parameters)
        self._reading_errors = sensing.reading_errors(parameters, steps, noise)
        self.load = inputs.load_force(parameters.load, record, steps)
        self._is_smooth = not self._is_closed and parameters.input.shape == "sine"
        self.reference = np.full(record.n_step, np.nan)
        self.voltage = np.zeros(record.n_step)
        if self._is_closed:
            self.reference = inputs.position_reference(
                parameters.input, parameters.control.amplitude, record, steps
            )
        else:
            self.voltage = inputs.input_voltage(parameters.input, record, steps)
        self._width = float(single["hysteresis"][0, 0])
        acting = accumulate(self.voltage.tolist(), self._after_hysteresis, initial=0.0)
        self._acting = np.array(list(acting)[1:])
        self.states = np.full((_SPOOL + 2, record.n_sample), np.nan)
        first, second = parameters.start_pressures
        self._state = np.array([
            0.0, 0.0, first, second, supply.pressure, 0.0, supply.return_pressure, parameters.start_support,
            first, 0.0, second, 0.0, 0.0, 0.0,
        ])  # fmt: skip
        self._error = self._integral = self._voltage = self._acting_voltage = 0.0

    def solve(self) -> None:
        """Fill the samples up to the point where the solver fails."""
        for first, last in pairwise(self._jumps()):
            if self._is_closed and first % self._steps_per_control == 0:
                self._control(first)
            if self._is_closed:
                self.voltage[first:last], self._acting[first:last] = self._voltage, self._acting_voltage
            if not self._advance(first, last):
                return

    def _jumps(self) -> list[int]:
        """Steps at which an input jumps, including the first and last step."""
        n_step = self._record.n_step
        jumps = {0, n_step, *(np.flatnonzero(np.diff(self.load)) + 1).tolist()}
        if self._is_closed:
            jumps.update(range(0, n_step, self._steps_per_control))
        elif not self._is_smooth:
            jumps.update((np.flatnonzero(np.diff(self.voltage)) + 1).tolist())
        return sorted(jumps)

    def _after_hysteresis(self, previous: float, voltage: float) -> float:
        acting: float = acting_voltage(voltage, previous, self._width)
        return acting

    def _control(self, step: int) -> None:
        c = self._single[0]
        position = float(self._state[0])
        if self._options.measured_feedback:
            position = valve.converted(
                c["reading_gain"][0] * position + self._reading_errors[step],
                c["lowest_reading"][0], c["highest_reading"][0], c["reading_resolution"][0],
            )  # fmt: skip
        error = float(self.reference[step] - position)
        self._voltage, self._integral = valve.pid_step(
            error, self._error, self._integral, c["proportional_gain"][0], c["integral_gain"][0],
            c["derivative_gain"][0], c["sample_time"][0], c["voltage_limit"][0],
        )  # fmt: skip
        self._error = error
        self._acting_voltage = self._after_hysteresis(self._acting_voltage, self._voltage)

    def _advance(self, first: int, last: int) -> bool:
        from scipy import integrate

        solve_ivp: Any = integrate.solve_ivp
        record, per_sample = self._record, self._record.steps_per_sample
        every = 1 if self._reader else per_sample
        steps = every * np.arange(-(-first // every), -(-last // every))
        instants = np.append(steps, last) * record.step
        held = self._acting if self._is_smooth else self._acting[first : first + 1]
        with np.errstate(all="ignore"):
            result = solve_ivp(
                all_rates, (first * record.step, last * record.step), self._state,
                method="LSODA" if self._solver == "lsoda" else "Radau", t_eval=instants,
                args=(held, float(self.load[first]), record.step, self._single, self._options),
                rtol=self._tolerance, atol=self._tolerance * _SCALES,
            )  # fmt: skip
        if not result.success or result.y.shape[1] < instants.size:
            return False
        if self._reader:
            self._reader(first, partial(self._signal, first, result.y[:, :-1]))
        is_sampled = steps % per_sample == 0
        self.states[:, steps[is_sampled] // per_sample] = result.y[:, :-1][:, is_sampled]
        self._state = result.y[:, -1]
        return True

    def _signal(self, first: int, states: NDArray[np.float64], name: str) -> NDArray[np.float64]:
        """A signal at every step from the first on, by its name in a trajectory: shape (n_step, 1)."""
        if name == "input_voltage":
            return self.voltage[first : first + states.shape[1], None]
        if name == "oil_temperature":
            time = self._record.step * (first + np.arange(states.shape[1]))
            return self._fluid.temperature_at(time)[:, None]
        values: NDArray[np.float64] = states[_SPOOL if name == "spool_position" else STATES.index(ROWS[name])]
        if name == "spool_position":
            limit = float(self._single["spool_limit"][0, 0])
            values = np.clip(values, -limit, limit)
        return values[:, None]


def all_rates(
    time: float,
    state: NDArray[np.float64],
    voltage: NDArray[np.float64],
    load: float,
    step: float,
    parameters: NDArray[Any],
    options: ModelOptions,
) -> NDArray[np.float64]:
    """Time derivatives of the hydraulic states, x_v and v_v."""
    place = min(max(time / step - 0.5, 0.0), voltage.size - 1.0)
    k = min(int(place), max(voltage.size - 2, 0))
    u = voltage[k] + (place - k) * (voltage[min(k + 1, voltage.size - 1)] - voltage[k])
    rates = np.empty(_SPOOL + 2)
    fill_rates(float(time), np.ascontiguousarray(state), float(u), load, parameters, rates, options)
    return rates


@recorded_kernel
def fill_rates(
    time: float,
    state: NDArray[np.float64],
    voltage: float,
    load: float,
    parameters: NDArray[Any],
    rates: NDArray[np.float64],
    options: ModelOptions,
) -> None:
    """Fill the time derivatives, with the voltage of the instant."""
    c, opened = parameters[0], options.limited_spool
    most, x_v, v_v = c.spool_limit[0], state[_SPOOL], state[_SPOOL + 1]
    p = hydraulics.lane_parameters(c, 0, time, time, options)
    x = hydraulics.State(*(state[k] for k in range(_SPOOL)))
    spool = kernel.spool_rates(
        x_v, v_v, voltage, c.spool_frequency[0], c.spool_damping_ratio[0], c.spool_gain[0], most,
        c.spool_speed_limit[0], opened,
    )  # fmt: skip
    for k, rate in enumerate(
        (*hydraulics.hydraulic_rates(x, kernel.valve_opening(x_v, most, opened), load, p, options), *spool)
    ):
        rates[k] = rate
