"""Internal leakage from an adaptive observer, and from a residual with an adaptive threshold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator

from hydrofdi.compilation.object_code import kernel
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.balancing import balance_outputs
from hydrofdi.indicators.contract import Output, RecursiveIndicator, RecursiveOptions, Trace
from hydrofdi.indicators.estimation.chamber_balance import valve_signals
from hydrofdi.indicators.estimation.valve_use import unclear_samples
from hydrofdi.indicators.faults import FLUID
from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.physics import Quantity, equation, signed_root
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI

P1, P2, POSITION, SPOOL, SUPPLY = range(5)
"""Signals of an observer: pressures [Pa], positions of piston and spool [m], and supply pressure [Pa]."""

N_SIGNAL = 5


@equation
def signals_at(signals: Array, row: int, k: int) -> tuple[float, float, float, float, float]:
    """Signals of a sample, in order."""
    one = signals[:, row, k]
    return one[P1], one[P2], one[POSITION], one[SPOOL], one[SUPPLY]


class Cylinder(NamedTuple):
    """Nominal actuator, in SI; volumes at position zero, K_v and w, and the return pressure."""

    area_1: float
    area_2: float
    volume_1: float
    volume_2: float
    flow_gain: float
    area_gradient: float
    ret: float


@equation
def nominal_flows(
    spool: Quantity, pressure_1: Quantity, pressure_2: Quantity, supply: Quantity, cylinder: Cylinder
) -> tuple[Quantity, Quantity]:
    """q_1 into chamber 1 and q_2 out of chamber 2 [m³/s]; all in SI."""
    ret, gain, gradient = cylinder.ret, cylinder.flow_gain, cylinder.area_gradient
    drop_1 = chamber_1_orifice_drop(spool, pressure_1, supply, ret)
    drop_2 = chamber_2_orifice_drop(spool, pressure_2, supply, ret)
    return control_flow(spool, drop_1, gain, gradient), control_flow(spool, drop_2, gain, gradient)


_BLOCK = 16
"""Number of consecutive samples of P_1 + P_2 that are averaged, if the valve is open at all of them."""


class ObserverOptions(NominalActuator, RecursiveOptions):
    """Options of observers of the chamber pressures."""

    supply_memory: Annotated[float, SI("s", above=0)] = 5.0
    """Time constant of the mean of P_1 + P_2, for ``supply: sum`` [s]."""

    least_opening: Annotated[float, SI("m", least=0)] = 5e-6
    """No adaptation while the spool is closer to its centre than this [m]: there the flow depends on lap and
    offset."""

    reference_pressure: Annotated[float, SI("Pa", least=1e4, most=2e8)] = 8e6
    """Pressure difference at which leakage flows are stated [Pa]."""

    @property
    def cylinder(self) -> Cylinder:
        """Parameters of the cylinder for kernels."""
        return Cylinder(*self.areas, *self.volumes, self.flow_gain, self.area_gradient, self.return_pressure)

    def observed(self, records: RecordBatch) -> tuple[Array, NDArray[np.bool_]]:
        """Signals (5, n_record, n_time) in SI, and samples without information (n_record, n_time).

        The order is that of the indices above.
        """
        shape = records.n_record, records.n_time
        signals, no_jump = np.empty((N_SIGNAL, *shape)), np.zeros(shape, dtype=np.bool_)
        signals[P1], signals[P2] = records[Channel.CHAMBER_1_PRESSURE], records[Channel.CHAMBER_2_PRESSURE]
        signals[POSITION] = self.position(records)
        signals[SPOOL] = self.spool_position(records)
        unclear = unclear_samples(signals[SPOOL], no_jump, 0, self.least_opening)
        total = signals[P1] + signals[P2] - self.return_pressure
        gain = -math.expm1(-_BLOCK / records.sampling_frequency / self.supply_memory)
        signals[SUPPLY] = self.supply_over_time(records, total, unclear, _BLOCK, gain)
        return signals, unclear


ERROR_1, ERROR_2, COEFFICIENT, COMPRESSIBILITY = range(4)
"""Indices of the state: e_1 and e_2 [Pa], K_i [m^3.5/kg^0.5] and 1/β [1/Pa]."""

_FLOW_1, _FLOW_2, _ROOT, _PRESSURE_1, _PRESSURE_2, _POSITION = range(4, 10)

N_STATE = 10


class AdaptationLaw(NamedTuple):
    """Adaptation law of an observer: sampling interval [s], L [1/s], and gains γ and γ_c.

    Beyond the limits of 1/β [1/Pa] and of abs(K_i) [m^3.5/kg^0.5] an estimate is not physical.
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
    law: AdaptationLaw,
    every: int,
    state: NDArray[np.float64],
    estimates: NDArray[np.float64],
) -> None:
    """Process samples, by the exact response of e to the mean flows over each sampling interval.

    `signals` (5, n_record, n_time) in the order of `nominal_signals`; no adaptation at `unclear` samples;
    `state` (n_record, N_STATE) contains the initial K_i and 1/β, and is updated in place; `estimates`
    (n_record, n_instant, 4): errors, K_i and 1/β of the state every `every` samples; K_i and 1/β are NaN once
    they are not physical.
    """
    # The error decays by exp(−L dt) over an interval and follows a constant input by (1 − exp(−L dt))/L.
    kept = math.exp(-law.injection * law.interval)
    lagged = (1.0 - kept) / (law.injection * law.interval)
    dt = law.interval
    for row in range(signals.shape[1]):
        s = state[row]
        i = 0
        for k in range(signals.shape[2]):
            p1, p2, x, spool, supply = signals_at(signals, row, k)
            q1, q2 = nominal_flows(spool, p1, p2, supply, cylinder)
            root = signed_root(p1 - p2)
            if k > 0:
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
            if (k + 1) % every == 0:
                for m in range(COMPRESSIBILITY + 1):
                    estimates[row, i, m] = s[m]
                i += 1


_MOST_RATIO = 10.0
"""Ratio of β to its nominal value, or its inverse, beyond which an estimate is not physical."""

_MOST_OPENING = 1e-3
"""Spool opening whose flow exceeds that of any leak [m]."""

Estimated = Literal["leakage", "compressibility"]


def _with_leakage(estimated: tuple[Estimated, ...]) -> tuple[Estimated, ...]:
    if "leakage" not in estimated:
        raise ValueError("leakage is always estimated: use [leakage] or [leakage, compressibility]")
    return estimated


class AdaptiveObserverOptions(ObserverOptions):
    """Options of `AdaptiveObserver`."""

    estimate: Annotated[tuple[Estimated, ...], AfterValidator(_with_leakage)] = ("leakage", "compressibility")
    """Adapted parameters: ``[leakage]``, or ``[leakage, compressibility]``; the compressibility is 1/β."""

    injection: Annotated[float, SI("1/s", above=0)] = 200.0
    """Rate at which the observer's pressures are corrected towards the measured ones [1/s]."""

    leakage_time: Annotated[float, SI("s", above=0)] = 1.5
    """Time constant of K_i if the pressures differ by ``reference_pressure`` [s]."""

    compressibility_time: Annotated[float, SI("s", above=0)] = 3.0
    """Time constant of 1/β if the pressures change at ``reference_rate`` [s]."""

    reference_rate: Annotated[float, SI("Pa/s", above=0)] = 20e6
    """RMS of the pressure rates [Pa/s], for changes slower than the injection."""

    transient: Annotated[float, SI("s", least=0)] = 3.0
    """Time excluded at the start of a record [s], while the observer adapts."""


class AdaptiveObserver(RecursiveIndicator[AdaptiveObserverOptions]):
    """Internal leakage and bulk modulus from adaptive pressure observers."""

    name = "adaptive_observer"
    version = 1
    source = "Garimella and Yao, Proc. American Control Conference (2005) 484; laws: Lyapunov's direct method"
    equation = (
        "V_1 P̂_1'/β̂ = q_1 − A v − K̂_i S + V_1 L e_1/β̂, chamber 2 alike, e = P − P̂, S = sgn(ΔP) √abs(ΔP);"
        " K̂_i' = −γ S (e_1 − e_2), (1/β̂)' = −γ_c Σ V r e with r the rate of P̂ without L"
    )
    caution = (
        "Errors of areas, position zero, supply and return pressure, flow gain and valve null appear as"
        " leakage, and nothing shows that the model does not fit. A record of only a"
        " few time constants still contains the initial settling: K_i from zero, β from the data sheet."
    )
    absence = (
        "the observer did not adapt, for example because the spool never opens, or it diverged: K_i or β is"
        " not physical, or a sample is missing"
    )
    Options = AdaptiveObserverOptions

    @property
    def estimates(self) -> tuple[Output, ...]:
        """Leakage, and the bulk modulus if it is estimated."""
        at, rising = f"at {self.options.reference_pressure / 1e6:g} MPa", Direction.RISING
        kept = {each.name: each for each in balance_outputs(self.options.reference_pressure)}
        modulus = Output("bulk_modulus", "Pa", "effective bulk modulus β", is_score=False, possible=FLUID)
        return (
            Output("leakage", "m^3/s", f"internal leakage flow of K_i {at}", direction=rising),
            Output.quality("leakage_spread", "m^3/s", "standard deviation of that flow over the record"),
            kept["internal_coefficient"],
            *([modulus] if self._adapts_compressibility else []),
        )

    @property
    def _adapts_compressibility(self) -> bool:
        return "compressibility" in self.options.estimate

    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Flow of K_i at the reference pressure [m³/s], and 1/β [1/Pa]."""
        state = np.zeros((records.n_record, N_STATE))
        state[:, COMPRESSIBILITY] = 1.0 / self.options.bulk_modulus
        every = self.samples_per_estimate(records.sampling_frequency)
        signals, unclear = self.options.observed(records)
        estimates = np.empty((records.n_record, due.size, COMPRESSIBILITY + 1))
        law = self._law(1.0 / records.sampling_frequency)
        adapt(signals, unclear, self.options.cylinder, law, every, state, estimates)
        flow = np.sqrt(self.options.reference_pressure) * estimates[:, :, COEFFICIENT]
        return {"leakage": flow, "compressibility": estimates[:, :, COMPRESSIBILITY]}

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """Means after the transient; NaN for parameters that did not adapt."""
        flow = _learned(trace.values["leakage"], 0.0)
        leakage = flow.mean(axis=1)
        values = {
            "leakage": leakage,
            "leakage_spread": flow.std(axis=1),
            "internal_coefficient": leakage / np.sqrt(self.options.reference_pressure),
        }
        if self._adapts_compressibility:
            learned = _learned(trace.values["compressibility"], 1.0 / self.options.bulk_modulus)
            values["bulk_modulus"] = 1.0 / learned.mean(axis=1)
        return values

    def _law(self, interval: float) -> AdaptationLaw:
        """Gains that give the time constants for the nominal actuator at mid-stroke."""
        options = self.options
        compressibility, volume = 1.0 / options.bulk_modulus, sum(options.volumes)
        drawn = compressibility * options.injection
        leakage_gain = drawn * volume / (4.0 * options.reference_pressure * options.leakage_time)
        rate = options.reference_rate**2
        compressibility_gain = drawn / (volume * rate * options.compressibility_time)
        opened = options.flow_gain * options.area_gradient * _MOST_OPENING
        return AdaptationLaw(
            interval, options.injection, leakage_gain,
            compressibility_gain if self._adapts_compressibility else 0.0,
            compressibility / _MOST_RATIO, compressibility * _MOST_RATIO, opened,
        )  # fmt: skip


def _learned(values: Array, start: float) -> Array:
    """Values over time; NaN in records in which they never change from the start value."""
    return np.where((values != start).any(axis=1, keepdims=True), values, np.nan)


N_SUM = 6
"""Number of projections: of S, of r, and of its derivatives by the parameters of `Bounds`, in order."""


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
    sums: NDArray[np.float64],
    blocks: NDArray[np.float64],
    every: int,
    estimates: NDArray[np.float64],
) -> None:
    """Process samples; a window consists of the latest blocks that contain valid samples.

    `signals` (5, n_record, n_time) in the order of `nominal_signals`; `unclear` samples are excluded; nominal
    `compressibility` 1/β [1/Pa]; sampling `interval` [s]; `sums` (N_SUM,) of the incomplete block is scratch;
    `blocks` (n_record, n_block, N_SUM) of `every` samples are zero at first.

    `estimates` (2, n_record, n_instant) are K_i from the residual, and its largest error from parameters
    within their bounds [m^3.5/kg^0.5]; NaN if there is no valid sample, the pressures are equal, or one is
    missing.
    """
    gain, ret = cylinder.flow_gain * cylinder.area_gradient, cylinder.ret
    for row in range(signals.shape[1]):
        n_block = 0
        last_flow, last_by_supply, last_by_offset, last_root = 0.0, 0.0, 0.0, 0.0
        last_p1, last_p2, last_x = 0.0, 0.0, 0.0
        for j in range(N_SUM):
            sums[j] = 0.0
        for k in range(signals.shape[2]):
            p1, p2, x, spool, supply = signals_at(signals, row, k)
            one = valve_signals(spool, p1, supply, supply, ret, gain, 1.0)
            two = valve_signals(spool, p2, supply, supply, ret, gain, -1.0)
            flow, by_supply = one.flow + two.flow, one.by_supply + two.by_supply
            by_offset, root = one.by_offset + two.by_offset, signed_root(p1 - p2)
            if k > 0 and not unclear[row, k]:
                # Trapezoidal rule over one sampling interval; volumes at its middle.
                half, middle = 0.5 * interval, 0.5 * (x + last_x)
                passed = half * (flow + last_flow)
                swept = (cylinder.area_1 + cylinder.area_2) * (x - last_x)
                rise_1 = (cylinder.volume_1 + cylinder.area_1 * middle) * (p1 - last_p1)
                rise_2 = (cylinder.volume_2 - cylinder.area_2 * middle) * (p2 - last_p2)
                compressed = compressibility * (rise_1 - rise_2)
                leak = half * (root + last_root)
                # Least squares of r = 2 K_i ∫S: numerator ∫r S, denominator 2 ∫S².
                sums[0] += 2.0 * leak * leak
                sums[1] += leak * (passed - swept - compressed)
                sums[2] += leak * compressed
                sums[3] += leak * passed
                sums[4] += leak * half * (by_supply + last_by_supply)
                sums[5] += leak * half * (by_offset + last_by_offset)
            last_flow, last_by_supply, last_by_offset, last_root = flow, by_supply, by_offset, root
            last_p1, last_p2, last_x = p1, p2, x
            if (k + 1) % every == 0:
                if sums[0] != 0.0:
                    # A ring of blocks: the window slides without sums that drift.
                    block = blocks[row, n_block % blocks.shape[1]]
                    n_block += 1
                    for j in range(N_SUM):
                        block[j], sums[j] = sums[j], 0.0
                i = k // every
                estimates[0, row, i], estimates[1, row, i] = projected(blocks[row], bounds)


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
            1.0 / frequency, np.zeros(N_SUM), np.zeros((n_record, n_block, N_SUM)),
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
