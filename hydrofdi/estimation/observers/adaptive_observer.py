"""Adaptive observer of the chamber pressures, internal leakage and compressibility.

The observed pressures follow from the nominal flows, corrected by injection of the measured values; a
persistent injection indicates parameter errors. With e the error of the observed pressures, c = 1/β and L the
injection::

    ĉ V_1 P̂_1' = q_1 − A_1 v − K̂_i S + ĉ V_1 L e_1       e_1 = P_1 − P̂_1
    ĉ V_2 P̂_2' = −q_2 + A_2 v + K̂_i S + ĉ V_2 L e_2      S = sgn(ΔP) √abs(ΔP)
    K̂_i' = −γ S (e_1 − e_2)
    ĉ'  = −γ_c (V_1 r_1 e_1 + V_2 r_2 e_2)                r: P̂' without the injection

The energy W = ½ c (V_1 e_1² + V_2 e_2²) + ½ (K_i − K̂_i)²/γ + ½ (c − ĉ)²/γ_c then has the rate
−c L (V_1 e_1² + V_2 e_2²) + ½ c v (A_1 e_1² − A_2 e_2²): it decreases, unless the piston sweeps its chamber
within the time 1/L. Garimella and Yao, Model based fault detection of an electro-hydraulic cylinder, Proc.
ACC (2005).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.estimation.observers.nominal_valve import (
    P1,
    P2,
    POSITION,
    SPOOL,
    SUPPLY,
    Cylinder,
    nominal_flows,
)
from hydrofdi.physics.signed_root import signed_root

ERROR_1, ERROR_2, COEFFICIENT, COMPRESSIBILITY = range(4)
"""Indices of the state: e_1 and e_2 [Pa], K_i [m^3.5/kg^0.5] and 1/β [1/Pa]."""

_FLOW_1, _FLOW_2, _ROOT, _PRESSURE_1, _PRESSURE_2, _POSITION = range(4, 10)

N_STATE = 10


class Law(NamedTuple):
    """Adaptation law of an observer.

    Attributes
    ----------
    interval : float
        Sampling interval [s].
    injection : float
        L [1/s].
    leakage_gain : float
        γ [m^5·s²/kg²]
    compressibility_gain : float
        γ_c [1/(Pa²·J)]
    least_compressibility, most_compressibility : float
        Physical limits of 1/β [1/Pa].
    most_coefficient : float
        Physical limit of abs(K_i) [m^3.5/kg^0.5].
    """

    interval: float
    injection: float
    leakage_gain: float
    compressibility_gain: float
    least_compressibility: float
    most_compressibility: float
    most_coefficient: float


@kernel
def adapt(
    signals: NDArray[np.float64],
    unclear: NDArray[np.bool_],
    cylinder: Cylinder,
    law: Law,
    n_before: int,
    every: int,
    state: NDArray[np.float64],
    estimates: NDArray[np.float64],
) -> None:
    """Process samples, by the exact response of e to the mean flows over each sampling interval.

    Parameters
    ----------
    signals : ndarray, shape (5, n_record, n_time)
        In the order of `nominal_valve`.
    unclear : ndarray of bool, shape (n_record, n_time)
        Samples without adaptation.
    cylinder : Cylinder
    law : Law
    n_before : int
        Number of samples of the stream before these.
    every : int
        Samples between estimates.
    state : ndarray, shape (n_record, 10)
        Updated in place; contains the initial K_i and 1/β.
    estimates : ndarray, shape (2, n_record, n_instant)
        Filled with K_i [m^3.5/kg^0.5] and 1/β [1/Pa]; NaN once they are not physical.
    """
    kept = math.exp(-law.injection * law.interval)
    lagged = (1.0 - kept) / (law.injection * law.interval)
    dt = law.interval
    for row in range(signals.shape[1]):
        s = state[row]
        i = 0
        for k in range(signals.shape[2]):
            p1, p2, x = signals[P1, row, k], signals[P2, row, k], signals[POSITION, row, k]
            q1, q2 = nominal_flows(signals[SPOOL, row, k], p1, p2, signals[SUPPLY, row, k], cylinder)
            root = signed_root(p1 - p2)
            if n_before + k > 0:
                middle, mean_root = 0.5 * (x + s[_POSITION]), 0.5 * (root + s[_ROOT])
                v1 = cylinder.volume_1 + cylinder.area_1 * middle
                v2 = cylinder.volume_2 - cylinder.area_2 * middle
                speed = (x - s[_POSITION]) / dt
                leak = s[COEFFICIENT] * mean_root
                net_1 = 0.5 * (q1 + s[_FLOW_1]) - cylinder.area_1 * speed - leak
                net_2 = leak + cylinder.area_2 * speed - 0.5 * (q2 + s[_FLOW_2])
                rate_1, rate_2 = net_1 / (s[COMPRESSIBILITY] * v1), net_2 / (s[COMPRESSIBILITY] * v2)
                e1 = kept * s[ERROR_1] + lagged * (p1 - s[_PRESSURE_1] - rate_1 * dt)
                e2 = kept * s[ERROR_2] + lagged * (p2 - s[_PRESSURE_2] - rate_2 * dt)
                mean_1, mean_2 = 0.5 * (e1 + s[ERROR_1]), 0.5 * (e2 + s[ERROR_2])
                if not unclear[row, k]:
                    s[COEFFICIENT] -= law.leakage_gain * dt * mean_root * (mean_1 - mean_2)
                    power = v1 * rate_1 * mean_1 + v2 * rate_2 * mean_2
                    s[COMPRESSIBILITY] -= law.compressibility_gain * dt * power
                s[ERROR_1], s[ERROR_2] = e1, e2
                is_physical = law.least_compressibility <= s[COMPRESSIBILITY] <= law.most_compressibility
                is_finite = abs(e1) + abs(e2) < np.inf
                if not (is_finite and is_physical and abs(s[COEFFICIENT]) <= law.most_coefficient):
                    s[COEFFICIENT] = s[COMPRESSIBILITY] = np.nan
            s[_FLOW_1], s[_FLOW_2], s[_ROOT] = q1, q2, root
            s[_PRESSURE_1], s[_PRESSURE_2], s[_POSITION] = p1, p2, x
            if (n_before + k + 1) % every == 0:
                estimates[0, row, i], estimates[1, row, i] = s[COEFFICIENT], s[COMPRESSIBILITY]
                i += 1
