"""The volume balance of a chamber, linear in the unknowns of the actuator."""

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
"""Unknowns of the balance, in the order of its columns: K_i, 1/β and deviations from the nominal actuator."""

N_UNKNOWN = len(UNKNOWNS)

COMPRESSIBILITY = UNKNOWNS.index("compressibility")

N_SHARED = 3
"""Integrals that both chambers use: of the position, of its rate, and of the root of the load pressure."""

N_OWN = 10
"""Integrals that each chamber has of its own."""

_LEAST_ROOT = 300.0
"""Root of the drop over an edge below which its slope is not trusted [√Pa]: 0.09 MPa."""


class Balance(NamedTuple):
    """What is known of the actuator and of the sums.

    Attributes
    ----------
    area_1, area_2 : float
        A of both chambers [m²].
    volume_1, volume_2 : float
        V of both chambers at position zero [m³].
    gain : float
        K_v w, flow gain times area gradient [m^2.5/kg^0.5].
    return_pressure : float
        P_r [Pa].
    compressibility : float
        Nominal 1/β [1/Pa].
    own_feed, other_feed : float
        What errors of the pressure of a chamber, and of the other one, do to the drop over its feeding edge:
        −1 and 0 where the supply pressure is known apart, 0 and 1 where it is the sum of both.
    half_time : float
        Half the length of a window [s].
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
    """Nominal flow of a chamber through the valve, and its slopes at one sample.

    Attributes
    ----------
    flow : float
        q_1 into chamber 1, or q_2 out of chamber 2 [m³/s].
    by_supply : float
        Slope by the supply pressure, relative to the one that it is stated about [m³/s].
    supply_error : float
        What the slope makes of the difference between the supply pressure that is used and that one [m³/s].
    by_offset, by_lap : float
        Slopes by the offset of the spool and the lap [m²/s].
    by_clearance : float
        P_s + P_r − 2 P [Pa].
    by_fed, by_drained : float
        Slopes by the drop over the feeding and the draining edge [m³/(s·Pa)].
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
    """Flow through the valve and its slopes; chamber 2 is chamber 1 seen from the other side (`sign` −1).

    Parameters
    ----------
    spool : float
        x_v [m].
    pressure : float
        Of the chamber [Pa].
    supply : float
        P_s at which the equations are linear [Pa].
    reference : float
        P_s about which its deviation is stated [Pa].
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
    """Fill the columns of a window (N_UNKNOWN,) from its integrals, and give its target [m³].

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
