"""Internal leakage from the residual of the volume balance, with an adaptive threshold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np

from hydrofdi.estimation.observers.reduced_order import N_STATE, N_SUM, Bounds, project
from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.nominal_signals import ObserverOptions, follow_signals, start_of_signals
from hydrofdi.indicators.recursive import RecursiveIndicator, State, Trace, instants
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI

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
    """Flow that the nominal actuator does not explain, and a bound on the effect of its errors."""

    name = "reduced_order"
    version = 1
    summary = (
        "Internal leakage from the residual of the volume balance, with a fixed or an adaptive threshold."
    )
    source = "Nurmi and Mattila, Int. J. Fluid Power 12 (2011), parts 1 and 2"
    equation = (
        "r = ∫(q_1 + q_2) − (A_1 + A_2) Δx_p − (V_1 ΔP_1 − V_2 ΔP_2)/β; residual = √Δp_ref ∫r S/∫2S²; bound ="
        " √Δp_ref Σ_p abs(∫(∂r/∂p) S) bound_p/∫2S², S = sgn(ΔP) √abs(ΔP)"
    )
    caution = (
        "Errors of supply pressure, flow gain and β appear as leakage. The exceedance reduces false alarms"
        " under such errors, but misses leaks smaller than the bound."
    )
    absence = "no window has an open valve, a pressure difference and all samples"
    Options = ReducedOrderOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """Pressures, position, and what moves the valve."""
        return self.options.needed

    @property
    def estimates(self) -> tuple[Output, ...]:
        """The residual for a fixed threshold, and its exceedance of the adaptive threshold."""
        at, rising = f"at {self.options.reference_pressure / 1e6:g} MPa", Direction.RISING
        return (
            Output("residual", "m^3/s", f"residual as an internal leakage flow {at}", direction=rising),
            Output("exceedance", "m^3/s", "residual minus the adaptive threshold", direction=rising),
            Output.quality("bound", "m^3/s", "adaptive threshold: largest residual from parameter errors"),
        )

    def start(self, records: RecordBatch) -> State:
        """An empty window."""
        n_block = max(1, round(self.options.window / self.options.interval))
        return start_of_signals(self.options, records) | {
            "block": np.zeros((records.n_record, N_STATE)),
            "blocks": np.zeros((records.n_record, n_block, N_SUM)),
        }

    def step(self, state: State, chunk: RecordBatch) -> tuple[State, Trace]:
        """Residual and bound of the window before each instant [m³/s]; shorter windows at the start."""
        options, frequency = self.options, chunk.sampling_frequency
        every, n_before = self.samples_per_estimate(frequency), int(state["n_sample"])
        due = instants(n_before, chunk.n_time, every)
        after, signals, unclear = follow_signals(options, state, chunk)
        estimates = np.empty((2, chunk.n_record, due.size))
        project(
            signals, unclear, options.cylinder, 1.0 / options.bulk_modulus, self._bounds(chunk),
            1.0 / frequency, n_before, after["block"], after["blocks"], every, estimates,
        )  # fmt: skip
        residual, bound = np.sqrt(options.reference_pressure) * estimates
        time = state["start_time"] + (n_before + due) / frequency
        return after, Trace(time, {"residual": residual, "exceedance": residual - bound, "bound": bound})

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """Means over the windows with information."""
        return {name: _mean(values) for name, values in trace.values.items()}

    def _bounds(self, records: RecordBatch) -> Bounds:
        options = self.options
        supply = options.supply_bound
        if supply is None:
            supply = _SUPPLY_BOUNDS[options.supply_known_by(records)]
        return Bounds(options.bulk_modulus_bound, options.flow_gain_bound, supply, options.offset_bound)


def _mean(values: Array) -> Array:
    """Mean of the finite values over time; NaN if there are none."""
    found = np.isfinite(values)
    return np.asarray(np.where(found, values, 0.0).sum(axis=1) / found.sum(axis=1))
