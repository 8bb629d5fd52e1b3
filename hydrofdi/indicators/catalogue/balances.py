"""Internal leakage and bulk modulus from volume balances: of whole records, by a spring, and recursively."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.indicators import balancing
from hydrofdi.indicators.catalogue.transients import alternating_side
from hydrofdi.indicators.contract import Indicator, Output, RecursiveIndicator, RecursiveOptions
from hydrofdi.indicators.estimation import weak_rls
from hydrofdi.indicators.estimation.chamber_balance import N_UNKNOWN, UNKNOWNS, windows_before
from hydrofdi.indicators.estimation.valve_use import clear_windows, unclear_samples
from hydrofdi.indicators.estimation.whole_record import mean_flows
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.data_sheet import PlantConstant
from hydrofdi.settings.quantities import ABOVE, SI


class BalanceOptions(balancing.WindowOptions):
    """Options of `BalanceIndicator`."""

    spool: Literal["measured", "command", "square"] = "measured"  # type: ignore[assignment]
    """Spool position: ``measured``; computed from the input voltage with the nominal valve (``command``); or
    a ``square`` wave that switches with the period of the drive or, if that is unknown, at the jumps of
    P_1."""

    drive_amplitude: Annotated[float, SI("V", above=0), PlantConstant("spool", ("square",))] = 2.0
    """Amplitude of the input voltage [V], for ``spool: square``."""

    leakage_deviation: Annotated[float, SI("m^3/s", above=0)] = 0.1 / 60.0
    """Prior standard deviation of the leakage flow, about zero [m³/s]."""

    robust: bool = False
    """Whether windows that fit poorly get less weight, such as those in which a force on the piston jumps."""

    def spool_position(self, records: RecordBatch) -> Array:
        """x_v [m], also for ``spool: square``."""
        if self.spool != "square":
            return super().spool_position(records)
        return self.spool_gain * self.drive_amplitude * alternating_side(records, records[balancing.P1])


Chosen = TypeVar("Chosen", bound=BalanceOptions)


class BalanceIndicator(Indicator[Chosen], Generic[Chosen]):
    """Maximum a posteriori estimate of leakage and actuator parameters from a record."""

    absence = "the balance does not determine the leakage"
    needs_scale = True
    by_spring = False

    @property
    def channels(self) -> frozenset[Channel]:
        """Without the position if the spring replaces it."""
        return self.options.channels - ({balancing.X} if self.by_spring else set())

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Estimates, most of them with standard deviations."""
        taken_up = balancing.TAKEN_UP_BY_SPRING if self.by_spring else balancing.TAKEN_UP
        return balancing.balance_outputs(self.options.reference_pressure, taken_up)

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if there are too few windows."""
        return self.options.lack_of_windows(records)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Estimates in SI, each (n_record,)."""
        options, balance = self.options, balancing.VolumeBalance(records, self.options, self.by_spring)
        deviations, supply = options.deviations(records), np.mean(balance.supply, axis=1)[:, None]
        columns, targets = balance.equations
        counts = balancing.counting_windows(balance.spool, records.sampling_frequency, options)
        weights = np.ones(targets.shape)
        for _ in range(_REWEIGHTING if options.robust else 0):
            estimates = self._found(records, columns, targets, counts, weights)
            left = targets - np.sum(columns * estimates[:, None, None, :N_UNKNOWN], axis=3)
            weights = _robust_weights(left * counts[:, :, None])
        estimates = self._found(records, columns, targets, counts, weights)
        if self.by_spring:
            # The valve flow of an open window stands for that of the piston.
            flow = np.abs(columns[:, :, 0, UNKNOWNS.index("flow_gain")]) * counts
            of_forces = _FORCES * np.sum(flow, axis=1) / np.maximum(np.sum(counts, axis=1), 1.0)
            of_forces *= records.sampling_frequency / options.half_window
            _add_error(estimates, of_forces, math.sqrt(options.reference_pressure))
        elif not options.robust:
            flows = mean_flows(balance, counts, np.zeros((records.n_record, N_UNKNOWN)))
            estimates[:, (weak_rls.MEAN, weak_rls.MEAN_ERROR)] = flows.T
        values = balancing.named_estimates(options, estimates[:, None], supply, deviations)
        # A model that does not explain the record does not determine the leakage either: the misfit says so.
        is_prior = (estimates[:, weak_rls.UNDETERMINED] > balancing.MOST_PRIOR) & (
            values["misfit"][:, 0] < balancing.FITS
        )
        return {name: np.where(is_prior, np.nan, array[:, 0]) for name, array in values.items()}

    def _found(
        self, records: RecordBatch, columns: Array, targets: Array, counts: Array, weights: Array
    ) -> Array:
        """Estimates (n_record, N_ESTIMATE) from weighted equations."""
        roots, n_record = np.sqrt(weights), records.n_record
        due, priors = np.array([columns.shape[1]]), np.zeros((n_record, 1, N_UNKNOWN))
        columns, targets = columns * roots[..., None], targets * roots
        estimates = balancing.follow_equations(
            self.options, records, columns, targets, counts, due, priors, 1.0
        )
        return estimates[:, 0]


_FORCES = 0.03
"""Relative deviation of the piston's speed if it is that of a spring: friction and other forces vary, too."""


def _add_error(estimates: Array, flow: Array, root: float) -> None:
    """Add the deviation of a flow (n_record,) to those of the estimates (n_record, N_ESTIMATE), in place."""
    leak = N_UNKNOWN + UNKNOWNS.index("internal_coefficient")
    for index, unit in ((leak, root), (weak_rls.COMBINED_ERROR, 1.0), (weak_rls.MEAN_ERROR, 1.0)):
        estimates[:, index] = np.hypot(estimates[:, index], flow / unit)


def _robust_weights(left: Array) -> Array:
    """Weight of each equation: 1/(1 + z²)², with z the residual over three robust standard deviations.

    Geman and McClure, Bull. Int. Stat. Inst. 52 (1987) 5. Residuals of zero do not count in the median.
    """
    size = np.abs(left).reshape(len(left), -1)
    with np.errstate(all="ignore"):
        middle = np.array(
            [np.median(np.extract(row > 0.0, row)) if np.any(row > 0.0) else 1.0 for row in size]
        )
        weights: Array = 1.0 / np.square(1.0 + np.square(left / (3.0 * 1.4826 * middle[:, None, None])))
    return weights


class FlowBalance(BalanceIndicator[BalanceOptions]):
    """Internal leakage, bulk modulus and valve parameters from the volume balance of the chambers."""

    name = "flow_balance"
    version = 7
    source = (
        "weak form: Shinbrot, NACA TN 3288 (1954); balance: equations (5) to (8) and (11) of the paper;"
        " deviations: Tarantola, Inverse Problem Theory (2005), section 3.2"
    )
    equation = (
        "∫φ(q_1 − A x_p') = K_i ∫φ sgn(ΔP) √abs(ΔP) + (1/β) ∫φ (V + A x_p) P_1', φ = sin²; chamber 2"
        " alike; q_1 = K_v w g_e (x_v − x_0 ∓ lap_e) √drop + c (P_s + P_r − 2 P_1) for the open edge e,"
        " c ≥ 0; 1/β + air (P_a/P)^(3/4)·3/(4P) for free air; P_s falls with the flow drawn; all but K_i are"
        " constrained to nominal values by their prior deviations. Errors have the standard deviation e, or"
        " e misfit if that is larger. Stated deviations of flows count the excess 50 times, allow three times"
        " the prior deviations, 5 % of the flow of c in K_i, and 30 % of mean_leakage for its law and place."
        " mean_leakage and cross_port_leakage follow from a second solution whose c may be that of a leak."
        " For the mean_leakage of a record each tenth of the way has its own K_i, which differs by three"
        " times the common one, and covariances of residuals of windows apart count like an excess"
    )
    caution = (
        "K_i (leakage) finds a hole or a scored bore whatever the valve leaks. mean_leakage and"
        " cross_port_leakage are right for any law, but contain the clearance of the valve: a gap is found"
        " beyond its null leakage alone, and cannot be told from a valve that leaks more. Pressure noise"
        " biases β upwards."
    )
    Options = BalanceOptions


class PressureBalanceOptions(BalanceOptions):
    """Options of `PressureBalance`: as for the flow balance, with longer windows after the ringing."""

    spool: Literal["measured", "command", "square"] = "command"
    """Spool position: ``measured``; computed from the input voltage with the nominal valve (``command``); or
    a ``square`` wave that switches with the period of the drive or, if that is unknown, at the jumps of
    P_1."""

    load_stiffness: Annotated[float, SI("N/m", least=0, most=1e12), PlantConstant()] = 150e3
    """Stiffness K_ex of the spring that loads the piston [N/m], used in place of the position."""

    half_window: Annotated[int, Field(strict=True, ge=2, le=100_000)] = 36
    """Half the length of a window [samples]; windows overlap by half."""

    settling: Annotated[float, SI("s", least=0)] = 0.1
    """Time excluded after a jump of the spool [s]: the pressures ring, but the position does not."""

    error: Annotated[float, SI("m^3", above=0)] = 10e-9
    """Standard deviation of the residual of a window's balance [m³]."""

    robust: bool = True
    """Whether windows that fit poorly get less weight, such as those in which a force on the piston jumps."""


class PressureBalance(BalanceIndicator[PressureBalanceOptions]):
    """Internal leakage from the volume balance, with the spring load in place of a position sensor."""

    name = "pressure_balance"
    version = 5
    source = "flow_balance with A x_p' = A² ΔP'/K_ex: specific to hydrofdi"
    equation = (
        "∫φ q_1 = K_i ∫φ sgn(ΔP) √abs(ΔP) + (A²/K_ex) ∫φ ΔP' + (1/β) ∫φ (V + A² ΔP/K_ex) P_1'; q_1 and"
        " unknowns as in flow_balance"
    )
    caution = (
        "Only for spring loads: other slowly varying forces appear as leakage; abrupt ones are"
        " down-weighted, and friction that rises with pressure shifts the leakage by 0.1 L/min: use it with"
        " the machine's own history. β is hardly distinguishable from the spring stiffness and stays near"
        " nominal."
    )
    by_spring = True
    Options = PressureBalanceOptions

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if there is no spring, or too few windows."""
        has_spring = self.options.load_stiffness > 0.0
        return super().obstacle(records) if has_spring else "it needs a load_stiffness above 0"


_REWEIGHTING = 4
"""Number of reweighting iterations if the estimate is robust."""


class WeakRlsOptions(balancing.WindowOptions, RecursiveOptions):
    """Options of `WeakRls`."""

    memory: Annotated[float, SI("s", above=0)] | Literal["none"] = 5.0
    """Memory of the trace: time after which the weight of a sample falls to 1/e [s]; ``none`` keeps all
    samples. The values of a record always use the whole record."""

    start_up: Annotated[float, SI("s", least=0)] = 0.5
    """Time excluded at the start of a record [s]: the earlier spool position is unknown."""

    least_jump: Annotated[float, SI("m", above=0)] = 8e-6
    """Travel of the spool between two samples that counts as a jump [m]."""

    def decay(self, records: RecordBatch) -> float:
        """Forgetting factor per window of the trace."""
        if self.memory == "none":
            return 1.0
        return math.exp(-self.half_window / records.sampling_frequency / self.memory)


@dataclass(frozen=True)
class RunningBalance(balancing.VolumeBalance):
    """The same with a supply pressure that is known from the samples before, (n_record, n_time)."""

    options: WeakRlsOptions

    @cached_property
    def supply(self) -> Array:
        """P_s at the linearisation point [Pa]."""
        records, options, first = self.records, self.options, self.records[balancing.P1]
        if options.n_pressure == 2:
            total = first + records[balancing.P2]
        else:
            total = 2.0 * first - options.load_stiffness / options.areas[0] * self.position
        every_sample = np.zeros(total.shape, dtype=np.bool_)
        total, gain = total - options.return_pressure, 1.0 - options.decay(records)
        return options.supply_over_time(records, total, every_sample, options.half_window, gain)

    @property
    def reference(self) -> Array:
        """P_s that its prior deviation refers to [Pa]."""
        is_known = self.options.supply_known_by(self.records) != "sum"
        return self.supply if is_known else np.full(self.supply.shape, self.options.supply_pressure)


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
        kept = balancing.balance_outputs(self.options.reference_pressure)
        return tuple(sorted(kept, key=lambda output: not output.name.startswith("leakage")))

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for estimates, or has too few windows."""
        return super().obstacle(records) or self.options.lack_of_windows(records)

    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Estimates with the memory."""
        values, _ = self._estimates(*self._balance(records), due, self.options.decay(records))
        return values | {"disagreement": np.full(values["leakage"].shape, np.nan)}

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Values in SI of whole records; the mean leakage allows for a leak in a part of the stroke."""
        every = self.samples_per_estimate(records.sampling_frequency)
        last, (balance, counts) = np.array([records.n_time // every * every - 1]), self._balance(records)
        estimates, undetermined = self._estimates(balance, counts, last, 1.0)
        is_prior = undetermined[:, 0] > balancing.MOST_PRIOR
        values = {name: np.where(is_prior, np.nan, array[:, 0]) for name, array in estimates.items()}
        flows = mean_flows(balance, counts, self._priors(balance, np.array([-1]))[:, 0])
        for name, flow in zip(("mean_leakage", "mean_leakage_error"), flows, strict=True):
            values[name] = np.where(np.isfinite(values[name]), flow, np.nan)
        return values | self.stored_trace(records)

    def _estimates(
        self, balance: RunningBalance, counts: Array, due: NDArray[np.intp], decay: float
    ) -> tuple[dict[str, Array], Array]:
        """Outputs after the samples `due`, and the share of the prior in the variance of K_i."""
        options, records = self.options, balance.records
        complete = np.array([windows_before(index + 1, options.half_window) for index in due], dtype=np.int64)
        given = *balance.equations, counts, complete, self._priors(balance, due), decay
        estimates = balancing.follow_equations(options, records, *given)
        reference, deviations = balance.reference[:, due], options.deviations(records)
        values = balancing.named_estimates(options, estimates, reference, deviations)
        return values, estimates[:, :, weak_rls.UNDETERMINED]

    def _balance(self, records: RecordBatch) -> tuple[RunningBalance, Array]:
        """The balance, and 1 for each of its windows that counts, else 0."""
        options, frequency = self.options, records.sampling_frequency
        balance = RunningBalance(records, options)
        jumps = np.abs(np.diff(balance.spool, prepend=balance.spool[:, :1])) > ABOVE * options.least_jump
        n_settling = round(options.settling * frequency)
        unclear = unclear_samples(balance.spool, jumps, n_settling, options.least_opening)
        unclear[:, : round(options.start_up * frequency)] = True
        return balance, clear_windows(unclear, options.half_window)

    def _priors(self, balance: RunningBalance, due: NDArray[np.intp]) -> Array:
        """Prior means over their deviations after the samples `due`, (n_record, n_instant, N_UNKNOWN)."""
        supply, reference = balance.supply[:, due], balance.reference[:, due]
        deviation = self.options.deviations(balance.records)[_SUPPLY]
        priors = np.zeros((*supply.shape, N_UNKNOWN))
        if deviation > 0.0:
            priors[:, :, _SUPPLY] = (supply / reference - 1.0) / deviation
        return priors


_SUPPLY = UNKNOWNS.index("supply")
