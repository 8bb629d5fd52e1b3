"""Internal leakage, bulk modulus and valve parameters from the volume balance, recursively."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.balancing import (
    MOST_PRIOR,
    P1,
    P2,
    WindowOptions,
    balance_outputs,
    follow_equations,
    named_estimates,
    window_equations,
)
from hydrofdi.indicators.contract import Output, RecursiveIndicator, RecursiveOptions, Trace
from hydrofdi.indicators.estimation import weak_rls
from hydrofdi.indicators.estimation.chamber_balance import N_UNKNOWN, UNKNOWNS, windows_before
from hydrofdi.indicators.estimation.whole_record import mean_flows
from hydrofdi.indicators.nominal_actuator import count_windows, mark_unclear
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI


class WeakRlsOptions(WindowOptions, RecursiveOptions):
    """Options of `WeakRls`."""

    memory: Annotated[float, SI("s", above=0)] | Literal["none"] = 5.0
    """Memory of the trace: time after which the weight of a sample falls to 1/e [s]; ``none`` keeps all
    samples. The values of a record always use the whole record."""

    start_up: Annotated[float, SI("s", least=0)] = 0.5
    """Time excluded at the start of a record [s]: the earlier spool position is unknown."""

    least_jump: Annotated[float, SI("m", above=0)] = 8e-6
    """Travel of the spool between two samples that counts as a jump [m]."""


class WeakRls(RecursiveIndicator[WeakRlsOptions]):
    """Internal leakage, bulk modulus and valve parameters by recursive least squares on the volume
    balance.
    """

    name = "weak_rls"
    version = 9
    source = (
        "weak form: Shinbrot, NACA TN 3288 (1954); forgetting: Ljung and Söderström, Theory and Practice of"
        " Recursive Identification (1983), chapter 2; a prior that is not forgotten is specific to hydrofdi"
    )
    equation = (
        "flow_balance's; θ = (Σ λ^(n−k) a_k a_kᵀ/s² + D⁻²)⁻¹ (Σ λ^(n−k) a_k y_k/s² + D⁻² θ_0), λ ="
        " exp(−hop/memory), s as in flow_balance"
    )
    caution = (
        "K_i (leakage) finds a hole or a scored bore; mean_leakage and cross_port_leakage also contain the"
        " clearance of the valve: a gap cannot be told from a valve that leaks more. Pressure noise biases β"
        " upwards; with one chamber, so does a leak. A misfit above 1.1 or a departure above 3 means that the"
        " data sheet does not fit; the flow gain absorbs a wrong piston area, so that the misfit alone does"
        " not show it. A disagreement above 2 means that the chambers state different leaks, as if one leaked"
        " to the outside."
    )
    absence = (
        "the record has samples that are not finite, does not determine the leakage, or is best explained by"
        " a supply pressure or flow gain that is not positive"
    )
    Options = WeakRlsOptions

    @property
    def estimates(self) -> tuple[Output, ...]:
        """Outputs of a volume balance, the leakage first."""
        kept = balance_outputs(self.options.reference_pressure)
        return tuple(sorted(kept, key=lambda output: not output.name.startswith("leakage")))

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for estimates, or has too few windows."""
        return super().obstacle(records) or self.options.lack_of_windows(records)

    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Estimates with the memory, and, as ``whole_…``, from all samples."""
        options, deviations = self.options, self.options.deviations(records)
        windows, (*_, supply, reference) = self._windows(records)
        supply, reference = supply[:, due], reference[:, due]
        complete = np.array([windows_before(place + 1, options.half_window) for place in due], dtype=np.int64)
        priors = self._priors(records, supply, reference)
        found = follow_equations(options, records, *windows, complete, priors, self._decays(records))
        values, whole = (
            named_estimates(options, found[:, place], reference, deviations) for place in (0, -1)
        )
        values["disagreement"] = np.full(values["leakage"].shape, np.nan)
        values["whole_undetermined"] = found[:, -1, :, weak_rls.UNDETERMINED]
        return values | {f"whole_{name}": array for name, array in whole.items()}

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Values in SI; the mean leakage allows for a leak in a part of the stroke."""
        values, options = dict(super().measure(records)), self.options
        windows, signals = self._windows(records)
        _, position, first, second, *supplies = signals
        priors = self._priors(records, *(each[:, -1:] for each in supplies))[:, 0]
        flows = mean_flows(
            windows, priors, options.assumptions(records), position, first - second, options.half_window,
            records.sampling_frequency,
        )  # fmt: skip
        for name, flow in zip(("mean_leakage", "mean_leakage_error"), flows, strict=True):
            values[name] = np.where(np.isfinite(values[name]), flow, np.nan)
        return values

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """Estimates from the whole record, if it determines the leakage."""
        whole = {each.name: trace.values[f"whole_{each.name}"][:, -1] for each in self.estimates}
        is_prior = trace.values["whole_undetermined"][:, -1] > MOST_PRIOR
        return {name: np.where(is_prior, np.nan, array) for name, array in whole.items()}

    def _windows(self, records: RecordBatch) -> tuple[tuple[Array, Array, Array], tuple[Array, ...]]:
        """Regressors, targets and counts of the windows, and the signals that they are made of."""
        options, frequency = self.options, records.sampling_frequency
        spool = options.spool_position(records)
        unclear = np.zeros(spool.shape, dtype=np.bool_)
        mark_unclear(
            spool, round(options.start_up * frequency), options.least_opening, options.least_jump,
            round(options.settling * frequency), unclear,
        )  # fmt: skip
        supply, reference = self._supply(records)
        first = records[P1]
        second = records[P2] if options.n_pressure == 2 else supply + options.return_pressure - first
        signals = spool, options.position(records), first, second, supply, reference
        columns, targets = window_equations(options, records, *signals)
        counts = np.zeros(columns.shape[:2])
        count_windows(unclear, options.half_window, counts)
        return (columns, targets, counts), signals

    def _priors(self, records: RecordBatch, supply: Array, reference: Array) -> Array:
        """Prior means over their deviations for given supply pressures, (n_record, n_instant, N_UNKNOWN)."""
        priors, deviation = np.zeros((*supply.shape, N_UNKNOWN)), self.options.deviations(records)[_SUPPLY]
        if deviation > 0.0:
            priors[:, :, _SUPPLY] = (supply / reference - 1.0) / deviation
        return priors

    def _supply(self, records: RecordBatch) -> tuple[Array, Array]:
        """P_s at the linearisation point, and the reference of its prior deviation [Pa]."""
        options, every_sample = self.options, np.zeros((records.n_record, records.n_time), dtype=np.bool_)
        if options.n_pressure == 2:
            total = records[P1] + records[P2]
        else:
            total = 2.0 * records[P1] - options.load_stiffness / options.areas[0] * options.position(records)
        gain = 1.0 - self._decays(records)[0]
        total = total - options.return_pressure
        supply = options.supply_over_time(records, total, every_sample, options.half_window, gain)
        is_known = options.supply_known_by(records) != "sum"
        return supply, supply if is_known else np.full(supply.shape, options.supply_pressure)

    def _decays(self, records: RecordBatch) -> Array:
        """Forgetting factors per window of the trace and of whole records; one value if both are equal."""
        memory = self.options.memory
        if memory == "none":
            return np.ones(1)
        return np.array([math.exp(-self.options.half_window / records.sampling_frequency / memory), 1.0])


_SUPPLY = UNKNOWNS.index("supply")
