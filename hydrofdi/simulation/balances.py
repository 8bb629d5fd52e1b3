"""The balances of volume and energy along a record: an account that does not trust the solver.

Flows and forces are computed again from the samples and integrated by the trapezoidal rule, so the residuals
hold the error of the simulation and that of the sampling. Sampled at every step, they show the former alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.physics.equation import equation
from hydrofdi.simulation.compilation import compiled
from hydrofdi.simulation.hydraulics import LaneParameters, State, friction_of, port_flows, row_parameters
from hydrofdi.simulation.lanes import parameter_matrix
from hydrofdi.simulation.options import ModelOptions, group_by_options
from hydrofdi.simulation.trajectory import Trajectory


@dataclass(frozen=True)
class BalanceResiduals:
    """What the balances of each run lack, each of shape (n_run,).

    Attributes
    ----------
    volume : ndarray
        abs[∫(q_1 − q_il − q_el1) dt − A Δx_p − ∫(V + A x_p)/β dP_1] / ∫abs(q_1) dt [-].
    energy : ndarray
        What supply = throttling + leakage + friction + kinetic and spring energy + compression lacks, over
        the energy of the supply [-].
    """

    volume: NDArray[np.float64]
    energy: NDArray[np.float64]


def balance_residuals(runs: Sequence[RunParameters], trajectory: Trajectory) -> BalanceResiduals:
    """Residuals of the balances of volume (chamber 1) and energy over the record of each run."""
    totals = np.zeros((len(runs), 4))
    parameters = parameter_matrix(runs, trajectory.leakage_coefficient.tolist())
    for options, members in group_by_options(runs):
        part = np.zeros((len(members), 4))
        integrate_balances(
            parameters[members], trajectory.spool_position[members],
            trajectory.piston_position[members], trajectory.piston_velocity[members],
            trajectory.chamber_1_pressure[members], trajectory.chamber_2_pressure[members],
            1.0 / runs[0].run.sampling_frequency, options, part,
        )  # fmt: skip
        totals[members] = part
    with np.errstate(all="ignore"):
        return BalanceResiduals(np.abs(totals[:, 0]) / totals[:, 1], np.abs(totals[:, 2]) / totals[:, 3])


class AccountRates(NamedTuple):
    """What a record adds to its account at an instant.

    Attributes
    ----------
    stored_volume, passed_volume : float
        Flow that stays in chamber 1 or is swept; size of the flow through port 1 [m³/s].
    stored_power, supplied_power : float
        Power that is neither lost nor leaves; size of the power of the supply [W].
    compliance_1, compliance_2 : float
        (V ± A x_p)/β of the chambers [m³/Pa].
    """

    stored_volume: float
    passed_volume: float
    stored_power: float
    supplied_power: float
    compliance_1: float
    compliance_2: float


@equation
def account_rates(
    state: State, spool_position: float, p: LaneParameters, options: ModelOptions
) -> AccountRates:
    """What a record adds to its account at an instant."""
    x, v, p1, p2 = state
    flows = port_flows(p1, p2, spool_position, p, options)
    lost = (
        (p1 - p2) * flows.internal
        + p1 * flows.external_1
        + p2 * flows.external_2
        + v * friction_of(v, p, options)
    )
    opened = spool_position >= 0.0
    port_1, port_2 = (p.supply, p.ret) if opened else (p.ret, p.supply)
    return AccountRates(
        flows.control_1 - flows.internal - flows.external_1,
        abs(flows.control_1),
        p1 * flows.control_1 - p2 * flows.control_2 - lost,
        abs(port_1 * flows.control_1 - port_2 * flows.control_2),
        (p.volume + p.area * x) / p.bulk_modulus,
        (p.volume - p.area * x) / p.bulk_modulus,
    )


@compiled
def integrate_balances(
    parameters: NDArray[np.float64],
    spool_position: NDArray[np.float64],
    position: NDArray[np.float64],
    velocity: NDArray[np.float64],
    pressure_1: NDArray[np.float64],
    pressure_2: NDArray[np.float64],
    interval: float,
    options: ModelOptions,
    totals: NDArray[np.float64],
) -> None:
    """Integrate the balances of several runs over their records.

    Parameters
    ----------
    parameters : ndarray, shape (n_run, n_parameter)
        In the order of ``lanes.PARAMETERS``.
    spool_position, position, velocity, pressure_1, pressure_2 : ndarray, shape (n_run, n_time)
        The samples, in SI.
    interval : float
        Time from one sample to the next [s].
    options : ModelOptions
        Choices that all runs share.
    totals : ndarray, shape (n_run, 4)
        Zeros, filled with the defect of the volume balance and the volume through port 1 [m³], the defect of
        the energy balance and the energy of the supply [J].
    """
    half = 0.5 * interval
    for run in range(position.shape[0]):
        p, total = row_parameters(parameters[run], 0.0, options), totals[run]
        x, v, p1, p2 = position[run, 0], velocity[run, 0], pressure_1[run, 0], pressure_2[run, 0]
        before = account_rates((x, v, p1, p2), spool_position[run, 0], p, options)
        for k in range(1, position.shape[1]):
            y, u, r1, r2 = position[run, k], velocity[run, k], pressure_1[run, k], pressure_2[run, k]
            p = row_parameters(parameters[run], k * interval, options)
            after = account_rates((y, u, r1, r2), spool_position[run, k], p, options)
            compressed = 0.5 * (before.compliance_1 + after.compliance_1) * (r1 - p1)
            work_1 = 0.5 * (p1 * before.compliance_1 + r1 * after.compliance_1) * (r1 - p1)
            work_2 = 0.5 * (p2 * before.compliance_2 + r2 * after.compliance_2) * (r2 - p2)
            held = 0.5 * (p.mass * (u * u - v * v) + p.stiffness * (y * y - x * x))
            total[0] += half * (before.stored_volume + after.stored_volume) - p.area * (y - x) - compressed
            total[1] += half * (before.passed_volume + after.passed_volume)
            total[2] += half * (before.stored_power + after.stored_power) - held - work_1 - work_2
            total[3] += half * (before.supplied_power + after.supplied_power)
            x, v, p1, p2, before = y, u, r1, r2, after
