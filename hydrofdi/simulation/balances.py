"""Sampled signals of runs, and their volume and energy balances: a check that does not depend on the solver.

Flows and forces are recomputed from the samples and integrated by the trapezoidal rule, so the residuals
contain the errors of simulation and sampling. If every step is sampled, only the simulation error remains.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import recorded_kernel
from hydrofdi.compilation.symbols import each, local, when
from hydrofdi.config import RunParameters
from hydrofdi.physics.cylinder import end_stop_force
from hydrofdi.simulation.hydraulics import (
    LaneParameters,
    State,
    bulk_modulus_at,
    chamber_2,
    friction_of,
    lane_parameters,
    port_flows,
    position_in_cylinder,
    support_velocity,
)
from hydrofdi.simulation.lanes import HIDDEN, ModelOptions, pack_singles, positions_by

Signal = NDArray[np.float64]


@dataclass(frozen=True)
class RunOutcome:
    """Outcome of a run: ``ok``, or the kind of failure and one sentence."""

    status: str = "ok"
    message: str = ""

    @property
    def is_ok(self) -> bool:
        """Whether the run succeeded, so that its results are valid."""
        return self.status == "ok"


@dataclass(frozen=True)
class Trajectory:
    """Sampled signals; every array but `time` has shape (n_run, n_time).

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        t_k = k/f_s [s].
    input_voltage : ndarray
        u [V].
    reference_position : ndarray
        Position reference in closed loop, NaN in open loop [m].
    load_force : ndarray
        F_L, against positive motion [N].
    spool_position, piston_position, piston_velocity : ndarray
        x_v [m], x_p [m], v_p [m/s].
    chamber_1_pressure, chamber_2_pressure : ndarray
        P_1, P_2 [Pa].
    valve_supply_pressure : ndarray
        P_s at the valve [Pa].
    bristle_deflection : ndarray
        z of the LuGre law; zero for the other laws [m].
    hidden_states : ndarray, shape (n_run, n_state, n_time)
        The states of ``lanes.HIDDEN``; none if no run has any.
    leakage_coefficient : ndarray, shape (n_run,)
        K_i [m^3.5/kg^0.5].
    internal_leakage_flow : ndarray
        q_il from chamber 1 to chamber 2 [m³/s].
    outcomes : tuple of RunOutcome, length n_run
        Outcome of each run.
    oil_temperature : ndarray, optional
        Temperature of the oil [K], NaN if a run does not state it; None if no run does.
    """

    time: Signal
    input_voltage: Signal
    reference_position: Signal
    load_force: Signal
    spool_position: Signal
    piston_position: Signal
    piston_velocity: Signal
    chamber_1_pressure: Signal
    chamber_2_pressure: Signal
    valve_supply_pressure: Signal
    bristle_deflection: Signal
    hidden_states: Signal
    leakage_coefficient: Signal
    internal_leakage_flow: Signal
    outcomes: tuple[RunOutcome, ...]
    oil_temperature: Signal | None = None

    def signals(self, names: Iterable[str]) -> dict[str, Signal]:
        """Signals by their names, without the oil temperature if there is none."""
        own = {name: getattr(self, name) for name in names}
        return {name: signal for name, signal in own.items() if signal is not None}

    @property
    def line_1_pressure(self) -> Signal:
        """Pressure at the valve of the hose to chamber 1 [Pa]; only if a run has hoses."""
        return self.hidden_states[:, list(HIDDEN).index("line_pressure_1")]

    @property
    def line_2_pressure(self) -> Signal:
        """Pressure at the valve of the hose to chamber 2 [Pa]; only if a run has hoses."""
        return self.hidden_states[:, list(HIDDEN).index("line_pressure_2")]

    @property
    def mean_internal_leakage_flow(self) -> Signal:
        """Mean of abs(q_il) over the samples [m³/s], shape (n_run,)."""
        mean: Signal = np.mean(np.abs(self.internal_leakage_flow), axis=1)
        return mean


class BalanceResiduals(NamedTuple):
    """Relative residuals of the volume and energy balances, each of shape (n_run,).

    Attributes
    ----------
    volume : ndarray
        abs[∫(q_1 − q_il − q_el1) dt − A_1 Δx_p − ∫(V_1 + A_1 x_p)/β dP_1] / ∫abs(q_1) dt [-]. If the
        chambers differ, the same of chamber 2 is subtracted, and abs(q_2) added.
    energy : ndarray
        Residual of supply = throttling + leakage + friction + kinetic, potential and spring energy
        + compression, relative to the energy supplied [-].
    """

    volume: NDArray[np.float64]
    energy: NDArray[np.float64]


_ACCOUNTED = (
    "piston_position", "piston_velocity", "chamber_1_pressure", "chamber_2_pressure",
    "valve_supply_pressure", "bristle_deflection", "spool_position", "load_force",
)  # fmt: skip
"""The states of a run that results store, then its spool and load."""


def balance_residuals(runs: Sequence[RunParameters], trajectory: Trajectory) -> BalanceResiduals:
    """Residuals of the volume balance (chamber 1) and energy balance over the record of each run."""
    totals = np.zeros((len(runs), 4))
    singles = pack_singles(runs, trajectory.leakage_coefficient.tolist())
    for options, members in positions_by(map(ModelOptions.of, runs)).items():
        rows = slice(None) if len(members) == len(runs) else members  # no copies
        part = np.zeros((len(members), 4))
        signals = np.array([getattr(trajectory, name)[rows] for name in _ACCOUNTED])
        hidden = np.ascontiguousarray(trajectory.hidden_states[rows])
        interval = 1.0 / runs[0].record.sampling_frequency
        integrate_balances(singles[rows], signals, hidden, interval, options, part)
        totals[members] = part
    # Diverged runs, and runs without flow, give infinity or NaN without a warning.
    with np.errstate(all="ignore"):
        return BalanceResiduals(np.abs(totals[:, 0]) / totals[:, 1], np.abs(totals[:, 2]) / totals[:, 3])


class AccountRates(NamedTuple):
    """Integrands of the balances at an instant.

    Attributes
    ----------
    stored_volume, stored_volume_2 : float
        Flow that is stored in chamber 1 or swept, and the same of chamber 2 [m³/s].
    passed_volume : float
        Absolute flow through port 1; if the chambers differ, through both ports [m³/s].
    stored_power, supplied_power : float
        Supplied power minus losses and outflow; absolute power of the supply [W].
    compliance_1, compliance_2 : float
        (V_1 + A_1 x_p)/β and (V_2 − A_2 x_p)/β [m³/Pa].
    """

    stored_volume: float
    stored_volume_2: float
    passed_volume: float
    stored_power: float
    supplied_power: float
    compliance_1: float
    compliance_2: float


def account_rates(
    state: State, spool_position: float, p: LaneParameters, options: ModelOptions
) -> AccountRates:
    """Integrands of the balances at an instant."""
    p1, p2 = state.pressure_1, state.pressure_2
    flows = port_flows(state, spool_position, p, options)
    friction, _ = friction_of(state, p, options)
    through, position = flows.valve, position_in_cylinder(state, options)
    stopped = end_stop_force(position, p.stop_position, p.stop_stiffness) if options.end_stops else 0.0
    support = support_velocity(state, friction + stopped, p, options)
    # Power that leaves oil and piston as heat, or with the oil that leaks out [W].
    lost = (
        through.throttling
        + (p1 - p2) * flows.internal
        + p1 * flows.external_1
        + p2 * flows.external_2
        # Friction acts between piston and cylinder, so on their relative velocity.
        + (state.velocity - support) * friction
    )
    if options.foundation:
        lost += p.support_damping * support * support
    if options.hoses:
        squares = state.line_flow_1 * state.line_flow_1 + state.line_flow_2 * state.line_flow_2
        # Δp q = R_h q² (5d).
        lost += p.hose_resistance * squares
    area_2, volume_2 = chamber_2(p, options)
    passed = abs(through.control_1)
    if options.unequal_chambers:
        passed += abs(through.control_2)
    ret = p.ret if not options.return_line else state.return_pressure
    # The returning oil carries P_r q_r away again.
    supplied = state.supply * through.supply - ret * through.returned
    return AccountRates(
        flows.into_1 - flows.internal - flows.external_1,
        flows.internal - flows.from_2 - flows.external_2,
        passed,
        supplied - lost,
        abs(supplied),
        # V/β by the β of the chamber: volume stored per rise of pressure.
        (p.volume + p.area * position) / bulk_modulus_at(p1, p, options),
        (volume_2 - area_2 * position) / bulk_modulus_at(p2, p, options),
    )


def held_energy(state: State, p: LaneParameters, options: ModelOptions) -> float:
    """Energy stored in the moving mass, its height, the springs, the end stops and the hoses [J]."""
    x, v = state.position, state.velocity
    energy: float = 0.5 * (p.mass * v * v + p.stiffness * x * x)
    if options.inclined:
        # m g times the height above the centre (2d).
        energy += p.weight * x
    if options.end_stops:
        force = end_stop_force(position_in_cylinder(state, options), p.stop_position, p.stop_stiffness)
        # F²/(2k) of the spring (2a), which is zero between the stops.
        energy += 0.5 * force * force / p.stop_stiffness
    if options.foundation:
        energy += 0.5 * p.support_stiffness * state.support * state.support
    if options.hoses:
        p1, p2, q1, q2 = state.line_pressure_1, state.line_pressure_2, state.line_flow_1, state.line_flow_2
        # Compression and kinetic energy of the oil in the hoses (5d).
        energy += 0.5 * p.hose_volume / p.hose_modulus * (p1 * p1 + p2 * p2)
        energy += 0.5 * p.hose_inertance * (q1 * q1 + q2 * q2)
    return energy


@recorded_kernel
def integrate_balances(
    parameters: NDArray[Any],
    signals: NDArray[np.float64],
    hidden: NDArray[np.float64],
    interval: float,
    options: ModelOptions,
    totals: NDArray[np.float64],
) -> None:
    """Integrate the balances of several runs over their records.

    Parameters
    ----------
    parameters : ndarray of SINGLE, shape (n_run,)
    signals : ndarray, shape (8, n_run, n_time)
        Samples of `_ACCOUNTED`, in SI.
    hidden : ndarray, shape (n_run, n_state, n_time)
        Those of the hidden states that the options need.
    interval : float
        Sampling interval [s].
    options : ModelOptions
        Options shared by all runs.
    totals : ndarray, shape (n_run, 4)
        Zeros on entry; filled with the residual of the volume balance and the volume through port 1 [m³], the
        residual of the energy balance and the energy supplied [J].
    """
    # Trapezoidal rule: half the interval times the sum of its ends.
    half = 0.5 * interval
    state_before, rates_before, held = local(len(State._fields)), local(len(AccountRates._fields)), local(1)
    *states, spool_position, load = range(len(_ACCOUNTED))
    for run in each(signals.shape[1]):
        total = totals[run]
        for k in each(signals.shape[2]):
            p = lane_parameters(parameters[run], 0, k * interval, k * interval, options)
            hides = [
                hidden[run, index, k] if getattr(options, option) else 0.0
                for index, option in enumerate(HIDDEN.values())
            ]
            z = State(*(signals[index, run, k] for index in states), *hides)
            after = account_rates(z, signals[spool_position, run, k], p, options)
            holds = held_energy(z, p, options)
            y = State(*map(state_before.__getitem__, range(len(z))))
            before = AccountRates(*map(rates_before.__getitem__, range(len(after))))
            with when(k > 0):
                rise_1, rise_2 = z.pressure_1 - y.pressure_1, z.pressure_2 - y.pressure_2
                # ∫ V/β dP over the pressure, so that no pressure rate is needed.
                compressed = 0.5 * (before.compliance_1 + after.compliance_1) * rise_1
                # ∫ P V/β dP, the work of compression; the product is averaged, not its factors.
                work_1 = (
                    0.5 * (y.pressure_1 * before.compliance_1 + z.pressure_1 * after.compliance_1) * rise_1
                )
                work_2 = (
                    0.5 * (y.pressure_2 * before.compliance_2 + z.pressure_2 * after.compliance_2) * rise_2
                )
                travel = z.position - y.position
                # The load is held from the sample before.
                work_on_load = signals[load, run, k - 1] * travel
                stored = half * (before.stored_volume + after.stored_volume)
                relative = position_in_cylinder(z, options) - position_in_cylinder(y, options)
                # (5) integrated over an interval; (6) is subtracted below.
                total[0] += stored - p.area * relative - compressed
                if options.unequal_chambers:
                    compressed = 0.5 * (before.compliance_2 + after.compliance_2) * rise_2
                    stored = half * (before.stored_volume_2 + after.stored_volume_2)
                    total[0] -= stored + p.area_2 * relative - compressed
                total[1] += half * (before.passed_volume + after.passed_volume)
                total[2] += half * (before.stored_power + after.stored_power)
                total[2] -= holds - held[0] + work_1 + work_2 + work_on_load
                total[3] += half * (before.supplied_power + after.supplied_power)
            # Only the instant before is kept: memory does not grow with the record.
            for index, value in enumerate(z):
                state_before[index] = value
            for index, value in enumerate(after):
                rates_before[index] = value
            held[0] = holds
