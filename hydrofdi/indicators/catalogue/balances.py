"""Internal leakage and bulk modulus from the volume balance, with the position or with a spring."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Generic, Literal, TypeVar

import numpy as np
from pydantic import Field

from hydrofdi.indicators.balancing import (
    FITS,
    MOST_PRIOR,
    P1,
    TAKEN_UP,
    TAKEN_UP_BY_SPRING,
    VolumeBalance,
    WindowOptions,
    X,
    balance_outputs,
    counting_windows,
    follow_equations,
    named_estimates,
)
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.estimation import weak_rls
from hydrofdi.indicators.estimation.chamber_balance import N_UNKNOWN, UNKNOWNS
from hydrofdi.indicators.estimation.whole_record import mean_flows
from hydrofdi.indicators.single_channel import alternating_side
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.data_sheet import PlantConstant
from hydrofdi.settings.quantities import SI


class BalanceOptions(WindowOptions):
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
        return self.spool_gain * self.drive_amplitude * alternating_side(records, records[P1])


Chosen = TypeVar("Chosen", bound=BalanceOptions)


class BalanceIndicator(Indicator[Chosen], Generic[Chosen]):
    """Maximum a posteriori estimate of leakage and actuator parameters from a record."""

    absence = "the balance does not determine the leakage"
    needs_scale = True
    by_spring = False

    @property
    def channels(self) -> frozenset[Channel]:
        """Without the position if the spring replaces it."""
        return self.options.channels - ({X} if self.by_spring else set())

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Estimates, most of them with standard deviations."""
        taken_up = TAKEN_UP_BY_SPRING if self.by_spring else TAKEN_UP
        return balance_outputs(self.options.reference_pressure, taken_up)

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if there are too few windows."""
        return self.options.lack_of_windows(records)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Estimates in SI, each (n_record,)."""
        options, balance = self.options, VolumeBalance(records, self.options, self.by_spring)
        deviations, supply = options.deviations(records), np.mean(balance.supply, axis=1)[:, None]
        columns, targets = balance.equations(balance.spool)
        counts = counting_windows(balance.spool, records.sampling_frequency, options)
        weights = np.ones(targets.shape)
        for _ in range(_REWEIGHTING if options.robust else 0):
            found = self._found(records, columns, targets, counts, weights)
            left = targets - np.sum(columns * found[:, None, None, :N_UNKNOWN], axis=3)
            weights = _robust_weights(left * counts[:, :, None])
        found = self._found(records, columns, targets, counts, weights)
        if self.by_spring:
            # The valve flow of an open window stands for that of the piston.
            flow = np.abs(columns[:, :, 0, UNKNOWNS.index("flow_gain")]) * counts
            of_forces = _FORCES * np.sum(flow, axis=1) / np.maximum(np.sum(counts, axis=1), 1.0)
            of_forces *= records.sampling_frequency / options.half_window
            _add_error(found, of_forces, math.sqrt(options.reference_pressure))
        elif not options.robust:
            (first, second), priors = balance.pressures, np.zeros((records.n_record, N_UNKNOWN))
            flows = mean_flows(
                (columns, targets, counts), priors, options.assumptions(records), balance.position,
                first - second, options.half_window, records.sampling_frequency,
            )  # fmt: skip
            found[:, (weak_rls.MEAN, weak_rls.MEAN_ERROR)] = np.stack(flows, axis=1)
        values = named_estimates(options, found[:, None], supply, deviations)
        # A model that does not explain the record does not determine the leakage either: the misfit says so.
        is_prior = (found[:, weak_rls.UNDETERMINED] > MOST_PRIOR) & (values["misfit"][:, 0] < FITS)
        return {name: np.where(is_prior, np.nan, array[:, 0]) for name, array in values.items()}

    def _found(
        self, records: RecordBatch, columns: Array, targets: Array, counts: Array, weights: Array
    ) -> Array:
        """Estimates (n_record, N_ESTIMATE) from weighted equations."""
        roots, n_record = np.sqrt(weights), records.n_record
        due, priors = np.array([columns.shape[1]]), np.zeros((n_record, 1, N_UNKNOWN))
        columns, targets = columns * roots[..., None], targets * roots
        found = follow_equations(self.options, records, columns, targets, counts, due, priors, np.ones(1))
        return found[:, 0, 0]


_FORCES = 0.03
"""Relative deviation of the piston's speed if it is that of a spring: friction and other forces vary, too."""


def _add_error(found: Array, flow: Array, root: float) -> None:
    """Add the deviation of a flow (n_record,) to those of the estimates (n_record, N_ESTIMATE), in place."""
    leak = N_UNKNOWN + UNKNOWNS.index("internal_coefficient")
    for place, unit in ((leak, root), (weak_rls.COMBINED_ERROR, 1.0), (weak_rls.MEAN_ERROR, 1.0)):
        found[:, place] = np.hypot(found[:, place], flow / unit)


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
