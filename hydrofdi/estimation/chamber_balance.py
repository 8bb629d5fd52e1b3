"""Volume balance of a chamber, linear in the unknown parameters of the actuator."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hydrofdi.physics.equation import equation
from hydrofdi.physics.signed_root import signed_root
from hydrofdi.physics.valve import chamber_1_orifice_drop

UNKNOWNS = (
    "internal_coefficient",
    "compressibility",
    "flow_gain",
    "supply",
    "offset",
    "lap",
    "clearance",
    "bias_1",
    "bias_2",
)
"""Unknowns of the balance, in column order: K_i, 1/β and deviations from the nominal actuator."""

N_UNKNOWN = len(UNKNOWNS)

COMPRESSIBILITY = UNKNOWNS.index("compressibility")

N_SHARED = 3
"""Number of integrals shared by both chambers: position, its rate, and root of the load pressure."""

N_OWN = 10
"""Number of integrals of each chamber."""

_LEAST_ROOT = 300.0
"""Root of the pressure drop at which the slope of an edge flow is limited [√Pa]: 0.09 MPa."""


class Balance(NamedTuple):
    """Known parameters of the actuator and of the windows.

    Attributes
    ----------
    area_1, area_2 : float
        Piston areas of both chambers [m²].
    volume_1, volume_2 : float
        Volumes of both chambers at position zero [m³].
    gain : float
        K_v w, flow gain times area gradient [m^2.5/kg^0.5].
    return_pressure : float
        P_r [Pa].
    compressibility : float
        Nominal 1/β [1/Pa].
    own_feed, other_feed : float
        Sensitivity of the drop over the feeding edge to errors of the chamber's own pressure and of the other
        one: −1 and 0 if the supply pressure is known independently, 0 and 1 if it is the sum of both.
    half_time : float
        Half the window length [s].
    """

    area_1: float
    area_2: float
    volume_1: float
    volume_2: float
    gain: float
    return_pressure: float
    compressibility: float
    own_feed: float
    other_feed: float
    half_time: float


class ValveSignals(NamedTuple):
    """Nominal valve flow of a chamber, and its partial derivatives at one sample.

    Attributes
    ----------
    flow : float
        q_1 into chamber 1, or q_2 out of chamber 2 [m³/s].
    by_supply : float
        Derivative by the supply pressure, relative to the reference supply pressure [m³/s].
    supply_error : float
        The same times the relative difference between the supply pressure used and the reference [m³/s].
    by_offset, by_lap : float
        Derivatives by the offset of the spool and by the lap [m²/s].
    by_clearance : float
        P_s + P_r − 2 P [Pa].
    by_fed, by_drained : float
        Derivatives by the pressure drop over the feeding and the draining edge [m³/(s·Pa)].
    """

    flow: float
    by_supply: float
    supply_error: float
    by_offset: float
    by_lap: float
    by_clearance: float
    by_fed: float
    by_drained: float


@equation
def valve_signals(
    spool: float, pressure: float, supply: float, reference: float, ret: float, gain: float, sign: float
) -> ValveSignals:
    """Valve flow of a chamber and its derivatives; chamber 2 mirrors chamber 1 (`sign` −1).

    Parameters
    ----------
    spool : float
        x_v [m].
    pressure : float
        Chamber pressure [Pa].
    supply : float
        P_s at the linearisation point [Pa].
    reference : float
        P_s that the prior deviation refers to [Pa].
    ret : float
        P_r [Pa].
    gain : float
        K_v w [m^2.5/kg^0.5].
    sign : float
        +1 for chamber 1, −1 for chamber 2.
    """
    root = signed_root(chamber_1_orifice_drop(sign * spool, pressure, supply, ret))
    opened = gain * root
    slope = 0.5 * gain * spool / max(abs(root), _LEAST_ROOT)
    fed = slope if sign * spool >= 0.0 else 0.0
    return ValveSignals(
        opened * spool,
        fed * reference,
        fed * (supply - reference),
        opened,
        opened * np.sign(spool),
        supply + ret - 2.0 * pressure,
        fed,
        slope - fed,
    )


@equation
def write_equation(
    sums: Any, chamber: int, b: Balance, position: float, leak: float, travel: float, columns: Any
) -> float:
    """Fill the regressors of a window (N_UNKNOWN,) from its integrals, and return its target [m³].

    Parameters
    ----------
    sums : ndarray, shape (N_OWN,)
        ∫ φ of each of `ValveSignals`, ∫ φ P', and ∫ φ τ P'.
    chamber : int
        0 or 1.
    b : Balance
    position, leak, travel : float
        ∫ φ x_p [m·s], ∫ φ sgn(ΔP) √|ΔP| [√Pa·s], ∫ φ x_p' [m].
    columns : ndarray, shape (N_UNKNOWN,)
    """
    sign = 1.0 if chamber == 0 else -1.0
    area = b.area_1 if chamber == 0 else b.area_2
    volume = b.volume_1 if chamber == 0 else b.volume_2
    flow, by_supply, supply_error, by_offset = sums[0], sums[1], sums[2], sums[3]
    by_lap, by_clearance, by_fed, by_drained = sums[4], sums[5], sums[6], sums[7]
    place, speed = position / b.half_time, travel / b.half_time
    compressed = sign * (volume + sign * area * place) * sums[8] + area * speed * sums[9]
    columns[0] = leak
    columns[1] = compressed
    columns[2] = -flow
    columns[3] = -by_supply
    columns[4] = by_offset
    columns[5] = by_lap
    columns[6] = -sign * by_clearance
    columns[7 + chamber] = by_drained + b.own_feed * by_fed
    columns[8 - chamber] = b.other_feed * by_fed
    target: float = flow - supply_error - area * travel - compressed * b.compressibility
    return target
