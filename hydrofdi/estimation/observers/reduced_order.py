"""Residual of the volume balance of both chambers, projected on the signature of a leak.

There are no pressure states. Between samples, the volume through the valve minus swept volume and compression
is the volume that crosses the piston seal. Over a window the residual r is projected on S = sgn(ΔP) √abs(ΔP),
so that K_i = ∫ r S/∫ 2 S². The same projection of ∂r/∂p gives the effect of an error of parameter p; with a
bound on this error it becomes an adaptive threshold. Nurmi and Mattila, Detection and isolation of leakage
and valve faults in hydraulic systems in varying loading conditions, Int. J. Fluid Power 12 (2011), parts 1
and 2.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.estimation.chamber_balance import valve_signals
from hydrofdi.estimation.observers.nominal_valve import P1, P2, POSITION, SPOOL, SUPPLY, Cylinder
from hydrofdi.physics.equation import equation
from hydrofdi.physics.signed_root import signed_root

_FLOW, _BY_SUPPLY, _BY_OFFSET, _ROOT, _PRESSURE_1, _PRESSURE_2, _POSITION = range(7)

_N_BEFORE = 7

N_SUM = 6
"""Number of projections: of S, of r, and of its derivatives by the parameters of `Bounds`, in order."""

N_STATE = _N_BEFORE + N_SUM + 1


class Bounds(NamedTuple):
    """Largest parameter errors of the nominal actuator; relative, except the offset of the spool [m]."""

    bulk_modulus: float
    flow_gain: float
    supply: float
    offset: float


@equation
def projected(blocks: Any, bounds: Bounds) -> tuple[float, float]:
    """K_i and its bound [m^3.5/kg^0.5], from the blocks of a window (n_block, N_SUM)."""
    whole, residual = 0.0, 0.0
    by_fluid, by_gain, by_supply, by_offset = 0.0, 0.0, 0.0, 0.0
    for j in range(blocks.shape[0]):
        whole += blocks[j, 0]
        residual += blocks[j, 1]
        by_fluid += blocks[j, 2]
        by_gain += blocks[j, 3]
        by_supply += blocks[j, 4]
        by_offset += blocks[j, 5]
    bound = abs(by_fluid) * bounds.bulk_modulus + abs(by_gain) * bounds.flow_gain
    bound += abs(by_supply) * bounds.supply + abs(by_offset) * bounds.offset
    return residual / whole, bound / whole


@kernel
def project(
    signals: NDArray[np.float64],
    unclear: NDArray[np.bool_],
    cylinder: Cylinder,
    compressibility: float,
    bounds: Bounds,
    interval: float,
    n_before: int,
    state: NDArray[np.float64],
    blocks: NDArray[np.float64],
    every: int,
    estimates: NDArray[np.float64],
) -> None:
    """Process samples; a window consists of the latest blocks that contain valid samples.

    Parameters
    ----------
    signals : ndarray, shape (5, n_record, n_time)
        In the order of `nominal_valve`.
    unclear : ndarray of bool, shape (n_record, n_time)
        Samples to exclude.
    cylinder : Cylinder
    compressibility : float
        Nominal 1/β [1/Pa].
    bounds : Bounds
    interval : float
        Sampling interval [s].
    n_before : int
        Samples of the stream before these.
    state : ndarray, shape (n_record, N_STATE)
        Previous sample, sums of the incomplete block, and number of complete blocks; updated in place.
    blocks : ndarray, shape (n_record, n_block, N_SUM)
        Sums of the blocks of a window; updated in place.
    every : int
        Samples per block.
    estimates : ndarray, shape (2, n_record, n_instant)
        Filled with K_i from the residual, and its largest error from parameters within their bounds
        [m^3.5/kg^0.5]; NaN if there is no valid sample, the pressures are equal, or a sample is missing.
    """
    gain, ret = cylinder.flow_gain * cylinder.area_gradient, cylinder.ret
    for row in range(signals.shape[1]):
        before, sums = state[row, :_N_BEFORE], state[row, _N_BEFORE:]
        i = 0
        for k in range(signals.shape[2]):
            p1, p2, x = signals[P1, row, k], signals[P2, row, k], signals[POSITION, row, k]
            spool, supply = signals[SPOOL, row, k], signals[SUPPLY, row, k]
            one = valve_signals(spool, p1, supply, supply, ret, gain, 1.0)
            two = valve_signals(spool, p2, supply, supply, ret, gain, -1.0)
            flow, by_supply = one.flow + two.flow, one.by_supply + two.by_supply
            by_offset, root = one.by_offset + two.by_offset, signed_root(p1 - p2)
            if n_before + k > 0 and not unclear[row, k]:
                half, middle = 0.5 * interval, 0.5 * (x + before[_POSITION])
                passed = half * (flow + before[_FLOW])
                swept = (cylinder.area_1 + cylinder.area_2) * (x - before[_POSITION])
                rise_1 = (cylinder.volume_1 + cylinder.area_1 * middle) * (p1 - before[_PRESSURE_1])
                rise_2 = (cylinder.volume_2 - cylinder.area_2 * middle) * (p2 - before[_PRESSURE_2])
                compressed = compressibility * (rise_1 - rise_2)
                leak = half * (root + before[_ROOT])
                sums[0] += 2.0 * leak * leak
                sums[1] += leak * (passed - swept - compressed)
                sums[2] += leak * compressed
                sums[3] += leak * passed
                sums[4] += leak * half * (by_supply + before[_BY_SUPPLY])
                sums[5] += leak * half * (by_offset + before[_BY_OFFSET])
            before[_FLOW], before[_BY_SUPPLY], before[_BY_OFFSET] = flow, by_supply, by_offset
            before[_ROOT], before[_PRESSURE_1], before[_PRESSURE_2], before[_POSITION] = root, p1, p2, x
            if (n_before + k + 1) % every == 0:
                if sums[0] != 0.0:
                    block = blocks[row, int(sums[N_SUM]) % blocks.shape[1]]
                    sums[N_SUM] += 1.0
                    for j in range(N_SUM):
                        block[j], sums[j] = sums[j], 0.0
                estimates[0, row, i], estimates[1, row, i] = projected(blocks[row], bounds)
                i += 1
