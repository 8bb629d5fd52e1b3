"""Internal leakage from the residual of the volume balance, with an adaptive threshold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.estimation.chamber_balance import valve_signals
from hydrofdi.indicators.nominal_signals import Cylinder, ObserverOptions, signals_at
from hydrofdi.indicators.recursive import RecursiveIndicator, Trace
from hydrofdi.physics.equation import equation, signed_root
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI

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
    # Errors of the worst signs: the parameters are bounded, not random.
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
    state: NDArray[np.float64],
    blocks: NDArray[np.float64],
    every: int,
    estimates: NDArray[np.float64],
) -> None:
    """Process samples; a window consists of the latest blocks that contain valid samples.

    `signals` (5, n_record, n_time) in the order of `nominal_signals`; `unclear` samples are excluded; nominal
    `compressibility` 1/β [1/Pa]; sampling `interval` [s]; `state` (n_record, N_STATE): previous sample, sums
    of the incomplete block, and number of complete ones; `blocks` (n_record, n_block, N_SUM) of `every`
    samples.

    `estimates` (2, n_record, n_instant) are K_i from the residual, and its largest error from parameters
    within their bounds [m^3.5/kg^0.5]; NaN if there is no valid sample, the pressures are equal, or one is
    missing.
    """
    gain, ret = cylinder.flow_gain * cylinder.area_gradient, cylinder.ret
    for row in range(signals.shape[1]):
        before, sums = state[row, :_N_BEFORE], state[row, _N_BEFORE:]
        i = 0
        for k in range(signals.shape[2]):
            p1, p2, x, spool, supply = signals_at(signals, row, k)
            one = valve_signals(spool, p1, supply, supply, ret, gain, 1.0)
            two = valve_signals(spool, p2, supply, supply, ret, gain, -1.0)
            flow, by_supply = one.flow + two.flow, one.by_supply + two.by_supply
            by_offset, root = one.by_offset + two.by_offset, signed_root(p1 - p2)
            if k > 0 and not unclear[row, k]:
                # Trapezoidal rule over one sampling interval; volumes at its middle.
                half, middle = 0.5 * interval, 0.5 * (x + before[_POSITION])
                passed = half * (flow + before[_FLOW])
                swept = (cylinder.area_1 + cylinder.area_2) * (x - before[_POSITION])
                rise_1 = (cylinder.volume_1 + cylinder.area_1 * middle) * (p1 - before[_PRESSURE_1])
                rise_2 = (cylinder.volume_2 - cylinder.area_2 * middle) * (p2 - before[_PRESSURE_2])
                compressed = compressibility * (rise_1 - rise_2)
                leak = half * (root + before[_ROOT])
                # Least squares of r = 2 K_i ∫S: numerator ∫r S, denominator 2 ∫S².
                sums[0] += 2.0 * leak * leak
                sums[1] += leak * (passed - swept - compressed)
                sums[2] += leak * compressed
                sums[3] += leak * passed
                sums[4] += leak * half * (by_supply + before[_BY_SUPPLY])
                sums[5] += leak * half * (by_offset + before[_BY_OFFSET])
            before[_FLOW], before[_BY_SUPPLY], before[_BY_OFFSET] = flow, by_supply, by_offset
            before[_ROOT], before[_PRESSURE_1], before[_PRESSURE_2], before[_POSITION] = root, p1, p2, x
            if (k + 1) % every == 0:
                if sums[0] != 0.0:
                    # A ring of blocks: the window slides without sums that drift.
                    block = blocks[row, int(sums[N_SUM]) % blocks.shape[1]]
                    sums[N_SUM] += 1.0
                    for j in range(N_SUM):
                        block[j], sums[j] = sums[j], 0.0
                estimates[0, row, i], estimates[1, row, i] = projected(blocks[row], bounds)
                i += 1


Share = Annotated[float, SI("1", least=0)]

_SUPPLY_BOUNDS = {"measured": 0.005, "sum": 0.01, "nominal": 0.05}


class ReducedOrderOptions(ObserverOptions):
    """Options of `ReducedOrder`."""

    window: Annotated[float, SI("s", above=0)] = 2.0
    """Length of the projection window [s], rounded to whole intervals of the trace; intervals without valid
    samples are not counted."""

    bulk_modulus_bound: Share = 0.2
    """Largest relative error of 1/β [-]."""

    flow_gain_bound: Share = 0.03
    """Largest relative error of the flow through the open valve [-]."""

    supply_bound: Share | None = None
    """Largest relative error of the supply pressure [-]; by default 0.005 if measured, 0.01 if from the sum
    of pressures, and 0.05 if nominal."""

    offset_bound: Annotated[float, SI("m", least=0)] = 0.4e-6
    """Largest absolute valve null [m]: the spool position at which the valve is closed."""


class ReducedOrder(RecursiveIndicator[ReducedOrderOptions]):
    """Internal leakage from the residual of the volume balance, with a fixed or an adaptive threshold."""

    name = "reduced_order"
    version = 1
    source = "Nurmi and Mattila, Int. J. Fluid Power 12 (2011), parts 1 and 2"
    equation = (
        "r = ∫(q_1 + q_2) − (A_1 + A_2) Δx_p − (V_1 ΔP_1 − V_2 ΔP_2)/β; residual = √Δp_ref ∫r S/∫2S²; bound ="
        " √Δp_ref Σ_p abs(∫(∂r/∂p) S) bound_p/∫2S², S = sgn(ΔP) √abs(ΔP)"
    )
    caution = (
        "Errors of areas, position zero, supply and return pressure, flow gain and β appear as leakage, and"
        " channels that are 2 ms apart as up to 0.1 L/min; nothing shows that the model does not fit. The"
        " exceedance reduces false alarms"
        " under such errors, but misses leaks smaller than the bound."
    )
    absence = "no window has an open valve, a pressure difference and all samples"
    Options = ReducedOrderOptions

    @property
    def estimates(self) -> tuple[Output, ...]:
        """The residual for a fixed threshold, and its exceedance of the adaptive threshold."""
        at, rising = f"at {self.options.reference_pressure / 1e6:g} MPa", Direction.RISING
        return (
            Output("residual", "m^3/s", f"residual as an internal leakage flow {at}", direction=rising),
            Output("exceedance", "m^3/s", "residual minus the adaptive threshold", direction=rising),
            Output.quality("bound", "m^3/s", "adaptive threshold: largest residual from parameter errors"),
        )

    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Residual and bound of the window before each instant [m³/s]; shorter windows at the start."""
        options, frequency, n_record = self.options, records.sampling_frequency, records.n_record
        signals, unclear = options.observed(records)
        supply = options.supply_bound
        if supply is None:
            supply = _SUPPLY_BOUNDS[options.supply_known_by(records)]
        bounds = Bounds(options.bulk_modulus_bound, options.flow_gain_bound, supply, options.offset_bound)
        n_block = max(1, round(options.window / options.interval))
        estimates = np.empty((2, n_record, due.size))
        project(
            signals, unclear, options.cylinder, 1.0 / options.bulk_modulus, bounds,
            1.0 / frequency, np.zeros((n_record, N_STATE)), np.zeros((n_record, n_block, N_SUM)),
            self.samples_per_estimate(frequency), estimates,
        )  # fmt: skip
        residual, bound = np.sqrt(options.reference_pressure) * estimates
        return {"residual": residual, "exceedance": residual - bound, "bound": bound}

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """Means over the windows with information."""
        means = {}
        for name, values in trace.values.items():
            is_known = np.isfinite(values)
            means[name] = np.where(is_known, values, 0.0).sum(axis=1) / is_known.sum(axis=1)
        return means
