"""Internal leakage from an adaptive observer of the chamber pressures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator

from hydrofdi.compilation.object_code import kernel
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.balancing import balance_outputs
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.faults import FLUID
from hydrofdi.indicators.nominal_signals import Cylinder, ObserverOptions, nominal_flows, signals_at
from hydrofdi.indicators.recursive import RecursiveIndicator, Trace
from hydrofdi.physics.equation import signed_root
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI

ERROR_1, ERROR_2, COEFFICIENT, COMPRESSIBILITY = range(4)
"""Indices of the state: e_1 and e_2 [Pa], K_i [m^3.5/kg^0.5] and 1/β [1/Pa]."""

_FLOW_1, _FLOW_2, _ROOT, _PRESSURE_1, _PRESSURE_2, _POSITION = range(4, 10)

N_STATE = 10


class Law(NamedTuple):
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
    law: Law,
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

    def _law(self, interval: float) -> Law:
        """Gains that give the time constants for the nominal actuator at mid-stroke."""
        options = self.options
        compressibility, volume = 1.0 / options.bulk_modulus, sum(options.volumes)
        drawn = compressibility * options.injection
        leakage_gain = drawn * volume / (4.0 * options.reference_pressure * options.leakage_time)
        rate = options.reference_rate**2
        compressibility_gain = drawn / (volume * rate * options.compressibility_time)
        opened = options.flow_gain * options.area_gradient * _MOST_OPENING
        return Law(
            interval, options.injection, leakage_gain,
            compressibility_gain if self._adapts_compressibility else 0.0,
            compressibility / _MOST_RATIO, compressibility * _MOST_RATIO, opened,
        )  # fmt: skip


def _learned(values: Array, start: float) -> Array:
    """Values over time; NaN in records in which they never change from the start value."""
    return np.where((values != start).any(axis=1, keepdims=True), values, np.nan)
