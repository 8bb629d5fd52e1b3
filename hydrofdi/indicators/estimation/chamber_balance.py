"""Volume balance of a chamber, linear in the unknown parameters of the actuator."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from hydrofdi.compilation.object_code import kernel
from hydrofdi.physics import equation, signed_root
from hydrofdi.physics.valve import chamber_1_orifice_drop
from hydrofdi.records import Array


@lru_cache(maxsize=64)
def weak_weights(half: int, sampling_frequency: float) -> Array:
    """Trapezoidal-rule weights of samples for integrals over windows of 2 `half` sampling intervals.

    Shape (2, 3, half): in the first and second half of a window, for ∫ φ s dt, ∫ φ s' dt and ∫ φ τ s' dt; φ
    is sin² over the window, τ the time from its middle. Adjacent windows overlap by half. φ' is scaled so
    that the sums are exact for a ramp: tan(π/(2 half)) replaces π/(2 half).
    """
    sample = np.arange(2 * half)
    phase = np.pi * sample / (2 * half)
    weight, slope = np.sin(phase) ** 2, np.sin(2.0 * phase) * np.tan(np.pi / (2 * half))
    late = (weight + slope * (sample - half)) / sampling_frequency
    weights = np.stack((weight / sampling_frequency, -slope, -late))
    return np.ascontiguousarray(weights.reshape(3, 2, half).transpose(1, 0, 2))


CURRENT, ENDING, BEFORE = 0, 1, 2
"""Rows of sums: current block as first and as second half of a window, and previous block."""


def windows_before(n_sample: int, half: int) -> int:
    """Number of windows that are complete after `n_sample` samples."""
    return max(n_sample // half - 1, 0)


@equation
def add(sums: Any, column: int, signal: float, first: float, second: float) -> None:
    """Add a weighted sample to the windows that start and end with this block."""
    sums[CURRENT, column] += first * signal
    sums[ENDING, column] += second * signal


@kernel
def integrate_windows(
    spool: Array,
    position: Array,
    pressures: Array,
    supply: Array,
    reference: Array,
    weights: Array,
    balance: Balance,
    sums: Array,
    columns: Array,
    targets: Array,
) -> None:
    """Fill the equations of the windows of records.

    `spool` and `position` (n_record, n_time) [m]; `pressures` (2, n_record, n_time), and `supply` at the
    linearisation point and the `reference` of its prior deviation, (n_record, n_time) [Pa]; `weights` from
    `weak_weights`; `sums` (n_record, 3, n_sum) is scratch, zero at first, its last column the low-passed flow
    from the supply; `columns` (n_record, n_window, n_chamber, N_UNKNOWN) and `targets` [m³] are filled.
    """
    n_record, n_time = spool.shape
    half, n_sum, n_chamber = weights.shape[2], sums.shape[2] - 1, targets.shape[2]
    for r in range(n_record):
        own = sums[r]
        n_window = 0
        for i in range(n_time):
            j = i % half
            if j == 0:
                for k in range(n_sum):
                    own[CURRENT, k] = own[ENDING, k] = 0.0
            first, second = weights[0, 0, j], weights[1, 0, j]
            x, x_v, p_1 = position[r, i], spool[r, i], pressures[0, r, i]
            # A block is the second half of one window and the first half of the next.
            add(own, 0, x, first, second)
            add(own, 1, signed_root(p_1 - pressures[1, r, i]), first, second)
            add(own, 2, x, weights[0, 1, j], weights[1, 1, j])
            drawn = own[CURRENT, n_sum]
            for chamber in range(n_chamber):
                sign, k = 1.0 if chamber == 0 else -1.0, N_SHARED + chamber * N_OWN
                p = pressures[chamber, r, i]
                signals = valve_signals(
                    x_v, p, supply[r, i], reference[r, i], balance.return_pressure, balance.gain, sign
                )
                for m in range(N_SIGNAL):
                    add(own, k + m, signals[m], first, second)
                add(own, k + 9, signals.by_fed * drawn, first, second)
                add(own, k + 10, p, weights[0, 1, j], weights[1, 1, j])
                add(own, k + 11, p, weights[0, 2, j], weights[1, 2, j])
                gas = released_gas(p)
                add(own, k + 12, gas, weights[0, 1, j], weights[1, 1, j])
                add(own, k + 13, gas, weights[0, 2, j], weights[1, 2, j])
                if sign * x_v > 0.0 or n_chamber == 1:
                    own[CURRENT, n_sum] = drawn + balance.supply_share * (abs(signals.flow) - drawn)
            if j == half - 1:
                if i >= half:
                    for k in range(n_sum):
                        own[BEFORE, k] += own[ENDING, k]
                    for chamber in range(n_chamber):
                        column = N_SHARED + chamber * N_OWN
                        targets[r, n_window, chamber] = write_equation(
                            own[BEFORE, column:], chamber, balance, own[BEFORE, 0], own[BEFORE, 1],
                            own[BEFORE, 2], columns[r, n_window, chamber],
                        )  # fmt: skip
                    n_window += 1
                for k in range(n_sum):
                    own[BEFORE, k] = own[CURRENT, k]


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
    "return_pressure",
    "free_air",
    "supply_resistance",
    "gain_by_direction",
    "gain_by_feeding",
    "gain_by_chamber",
    "lap_by_feeding",
    "lap_by_chamber",
)
"""Unknowns of the balance, in column order: K_i, 1/β and deviations from the nominal actuator.

Gain and lap of the four metering edges are their means and contrasts: between the edges that are open at a
positive and at a negative spool position (of the lap, this is the offset), between feeding and draining
edges, and between the chambers.
"""

N_UNKNOWN = len(UNKNOWNS)

COMPRESSIBILITY = UNKNOWNS.index("compressibility")

N_SHARED = 3
"""Number of integrals shared by both chambers: position, its rate, and root of the load pressure."""

N_SIGNAL, N_OWN = 9, 14
"""Number of `ValveSignals`, and of all integrals of each chamber."""

_ATMOSPHERE = 101325.0

_LEAST_ROOT = 300.0
"""Root of the pressure drop at which the slope of an edge flow is limited [√Pa]: 0.09 MPa."""


class Balance(NamedTuple):
    """Known parameters of the actuator and of the windows.

    Areas [m²], volumes at position zero [m³], gain K_v w [m^2.5/kg^0.5], P_r [Pa], nominal 1/β [1/Pa], and
    half the window length [s]. `own_feed` and `other_feed` are the sensitivities of the drop over the feeding
    edge to errors of the chamber's own pressure and of the other one: −1 and 0 if the supply pressure is
    known independently, 0 and 1 if it is the sum of both. `supply_share`: gain per sample of the low-pass of
    the flow from the supply. `gas_slope`: derivative of `released_gas` at the pressure to which β refers.
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
    supply_share: float
    gas_slope: float


class ValveSignals(NamedTuple):
    """Nominal valve flow of a chamber, and its partial derivatives at one sample.

    `flow` is q_1 into chamber 1, or q_2 out of chamber 2 [m³/s]; `by_supply` its derivative by the supply
    pressure, relative to the reference, and `supply_error` the same times the relative difference between the
    supply pressure used and the reference [m³/s]; `by_offset` and `by_lap` [m²/s]; `by_clearance` is P_s +
    P_r − 2 P [Pa]; `by_fed` and `by_drained` by the drops over both edges [m³/(s·Pa)]; `by_direction` is the
    flow times the sign of the spool position.
    """

    flow: float
    by_supply: float
    supply_error: float
    by_offset: float
    by_lap: float
    by_clearance: float
    by_fed: float
    by_drained: float
    by_direction: float


@equation
def released_gas(pressure: float) -> float:
    """Volume of free air over that at atmospheric pressure, negative; the polytropic exponent is 4/3."""
    # P^(-3/4) needs only square roots; the pressure is limited to the atmospheric one.
    root = np.sqrt(_ATMOSPHERE / (max(pressure, 0.0) + _ATMOSPHERE))
    gas: float = -root * np.sqrt(root)
    return gas


def gas_slope(pressure: float) -> float:
    """Derivative of `released_gas` [1/Pa]."""
    slope: float = 0.75 * (_ATMOSPHERE / (pressure + _ATMOSPHERE)) ** 0.75 / (pressure + _ATMOSPHERE)
    return slope


@equation
def valve_signals(
    spool: float, pressure: float, supply: float, reference: float, ret: float, gain: float, sign: float
) -> ValveSignals:
    """Valve flow of a chamber and its derivatives, in SI; chamber 2 mirrors chamber 1 (`sign` −1).

    `supply` is P_s at the linearisation point, `reference` the P_s that the prior deviation refers to, `gain`
    is K_v w.
    """
    # Equations (7) and (8), with a limited slope where the drop vanishes.
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
        opened * abs(spool),
    )


@equation
def write_equation(
    sums: Any, chamber: int, b: Balance, position: float, leak: float, travel: float, columns: Any
) -> float:
    """Fill the regressors of a window (N_UNKNOWN,) from its integrals, and return its target [m³].

    `sums` (N_OWN,): ∫ φ of each of `ValveSignals`, ∫ φ P' and ∫ φ τ P'; `position`, `leak` and `travel`: ∫ φ
    x_p, ∫ φ sgn(ΔP) √|ΔP| and ∫ φ x_p'.
    """
    sign = 1.0 if chamber == 0 else -1.0
    area = b.area_1 if chamber == 0 else b.area_2
    volume = b.volume_1 if chamber == 0 else b.volume_2
    flow, by_supply, supply_error, by_offset = sums[0], sums[1], sums[2], sums[3]
    by_lap, by_clearance, by_fed, by_drained = sums[4], sums[5], sums[6], sums[7]
    middle, speed = position / b.half_time, travel / b.half_time
    # Equations (5) and (6): ∫ φ (V ± A x_p) P', with x_p(τ) ≈ middle + speed τ about that of the window.
    at_middle = sign * (volume + sign * area * middle)
    compressed = at_middle * sums[10] + area * speed * sums[11]
    columns[0] = leak
    columns[1] = compressed
    columns[2] = -flow
    columns[3] = -by_supply
    columns[4] = by_offset
    columns[5] = by_lap
    columns[6] = -sign * by_clearance
    columns[7 + chamber] = by_drained + b.own_feed * by_fed
    columns[8 - chamber] = b.other_feed * by_fed
    # P_s follows from the sum of the pressures minus P_r if it is not known independently.
    columns[9] = by_drained + 0.5 * (1.0 + b.own_feed + b.other_feed) * by_fed
    # β includes the air at its reference pressure: the air adds only what differs at other pressures.
    columns[10] = at_middle * sums[12] + area * speed * sums[13] - b.gas_slope * compressed
    columns[11] = sums[9]
    columns[12] = -sums[8]
    columns[13] = -sign * sums[8]
    columns[14] = -sign * flow
    columns[15] = sign * by_offset
    columns[16] = sign * by_lap
    target: float = flow - supply_error - area * travel - compressed * b.compressibility
    return target
