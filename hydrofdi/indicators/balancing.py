"""Common parts of the volume-balance indicators."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.estimation import chamber_balance, weak_rls
from hydrofdi.indicators.estimation.valve_use import clear_windows, unclear_samples
from hydrofdi.indicators.faults import FLUID, POSITIVE
from hydrofdi.indicators.nominal_actuator import UncertainActuator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION


@dataclass(frozen=True)
class VolumeBalance:
    """Volume balance equations of the chambers, integrated over the windows.

    With one pressure, P_2 = P_s + P_r − P_1, and only the balance of chamber 1 is used. `by_spring`: the
    position is computed from the pressure difference and the load spring.
    """

    records: RecordBatch
    options: WindowOptions
    by_spring: bool = False

    @cached_property
    def spool(self) -> Array:
        """Spool position x_v [m]."""
        return self.options.spool_position(self.records)

    @cached_property
    def supply(self) -> Array:
        """P_s [Pa], shape (n_record, n_time) or (n_record, 1)."""
        records, options = self.records, self.options
        match options.supply_known_by(records):
            case "measured":
                return records[Channel.SUPPLY_PRESSURE]
            case "nominal":
                return np.full((records.n_record, 1), options.supply_pressure)
        if self.options.n_pressure == 2:
            total = np.median(records[P1] + records[P2], axis=1, keepdims=True)
        else:
            total = 2.0 * np.mean(records[P1], axis=1, keepdims=True)
            if not self.by_spring:
                stiffness = options.load_stiffness / options.areas[0]
                total = total - stiffness * np.mean(options.position(records), axis=1, keepdims=True)
        return np.asarray(total - options.return_pressure)

    @cached_property
    def pressures(self) -> tuple[Array, Array]:
        """P_1 and P_2 [Pa]."""
        first = self.records[P1]
        if self.options.n_pressure == 2:
            return first, self.records[P2]
        return first, self.supply + self.options.return_pressure - first

    @cached_property
    def position(self) -> Array:
        """x_p [m]."""
        if not self.by_spring:
            return self.options.position(self.records)
        (area_1, area_2), (first, second) = self.options.areas, self.pressures
        return (area_1 * first - area_2 * second) / self.options.load_stiffness

    @property
    def reference(self) -> Array:
        """P_s that its prior deviation refers to [Pa]."""
        return self.supply

    @cached_property
    def equations(self) -> tuple[Array, Array]:
        """`window_equations` of whole records."""
        signals = self.spool, self.position, *self.pressures, self.supply, self.reference
        return window_equations(self.options, self.records, *signals)


def window_equations(options: WindowOptions, records: RecordBatch, *signals: Array) -> tuple[Array, Array]:
    """Equations of the windows of records.

    Regressors (n_record, n_window, n_chamber, N_UNKNOWN) and targets [m³]. The `signals`: x_v, x_p [m], P_1,
    P_2, P_s at the linearisation point and the reference of its prior deviation [Pa].
    """
    shape, half = (records.n_record, records.n_time), options.half_window
    spool, position, first, second, supply, reference = (
        np.ascontiguousarray(np.broadcast_to(signal, shape)) for signal in signals
    )
    targets = np.zeros(
        (records.n_record, chamber_balance.windows_before(records.n_time, half), options.n_pressure)
    )
    columns = np.zeros((*targets.shape, chamber_balance.N_UNKNOWN))
    # The last one is the low-passed flow from the supply.
    n_sum = chamber_balance.N_SHARED + options.n_pressure * chamber_balance.N_OWN + 1
    chamber_balance.integrate_windows(
        spool, position, np.stack((first, second)), supply, reference,
        chamber_balance.weak_weights(half, records.sampling_frequency), _known_balance(options, records),
        np.zeros((records.n_record, 3, n_sum)), columns, targets,
    )  # fmt: skip
    return columns, targets


def _known_balance(options: WindowOptions, records: RecordBatch) -> chamber_balance.Balance:
    """Known parameters of the equations.

    Errors of pressures that determine the supply pressure are included.
    """
    own_feed, other_feed = -1.0, 0.0
    if options.supply_known_by(records) == "sum":
        own_feed, other_feed = (0.0, 1.0) if options.n_pressure == 2 else (1.0, 0.0)
    return chamber_balance.Balance(
        *options.areas, *options.volumes, options.flow_gain * options.area_gradient, options.return_pressure,
        1.0 / options.bulk_modulus, own_feed, other_feed, options.half_window / records.sampling_frequency,
        1.0 - math.exp(-1.0 / (0.1 * records.sampling_frequency)),
        chamber_balance.gas_slope(0.5 * (options.supply_pressure + options.return_pressure)),
    )  # fmt: skip


def follow_equations(
    options: WindowOptions, records: RecordBatch, columns: Array, targets: Array, counts: Array,
    due: NDArray[np.int64], priors: Array, decay: float,
) -> Array:  # fmt: skip
    """Estimates (n_record, n_instant, N_ESTIMATE); arguments as of `weak_rls.follow_windows`."""
    estimates = np.full((records.n_record, due.size, weak_rls.N_ESTIMATE), np.nan)
    state = weak_rls.new_state(records.n_record, targets.shape[2])
    weak_rls.follow_windows(
        columns, targets, counts, due, priors, options.assumptions(records), decay, state,
        weak_rls.new_scratch(), estimates,
    )  # fmt: skip
    return estimates


MOST_PRIOR = 0.81
"""Variance of K_i over that of its prior from which on the record does not determine it."""

FITS = 1.1
"""Largest misfit of a model that explains a record."""


class WindowOptions(UncertainActuator):
    """Prior knowledge of the actuator, its uncertainty, and the selection of windows."""

    chambers: Literal["both", 1] = "both"
    """Chamber pressures that are used. ``1``: only that of chamber 1; the other follows from a matched
    valve."""

    half_window: Annotated[int, Field(strict=True, ge=2, le=100_000)] = 16
    """Half the length of a window [samples]; windows overlap by half."""

    least_opening: Annotated[float, SI("m", least=0)] = 3e-6
    """Windows in which the spool is closer to its centre than this are excluded [m]: there the flow depends
    on lap and offset."""

    settling: Annotated[float, SI("s", least=0)] = 0.0
    """Time excluded after a jump of the spool [s]: a sudden change by a twentieth of its range between two
    samples. The jump itself is always excluded, because samples do not resolve the flow during it."""

    error: Annotated[float, SI("m^3", above=0)] = 4e-9
    """Standard deviation of the residual of a window's balance [m³]; it weights the record against the prior
    deviations of the actuator."""

    reference_pressure: Annotated[float, SI("Pa", least=1e4, most=2e8)] = 8e6
    """Pressure difference at which leakage flows are stated [Pa]."""

    leakage_deviation: Annotated[float, SI("m^3/s", above=0)] = 1e-3 / 60.0
    """Prior standard deviation of the leakage flow, about zero [m³/s]."""

    @property
    def channels(self) -> frozenset[Channel]:
        """Pressures, position, and what moves the valve."""
        return super().channels - (set() if self.chambers == "both" else {P2})

    @property
    def n_pressure(self) -> int:
        """Number of chamber pressures that are used."""
        return 2 if self.chambers == "both" else 1

    def deviations(self, records: RecordBatch) -> Array:
        """Prior standard deviations of all unknowns; zero if known."""
        known = self.prior_deviations(records, self.n_pressure)
        known["internal_coefficient"] = self.leakage_deviation / math.sqrt(self.reference_pressure)
        return np.array([known.get(name, 0.0) for name in chamber_balance.UNKNOWNS])

    def assumptions(self, records: RecordBatch) -> weak_rls.Assumptions:
        """What is known before the first window."""
        return weak_rls.Assumptions(
            self.deviations(records), self.error, self.reference_pressure,
            self.half_window / records.sampling_frequency, self.bulk_modulus,
        )  # fmt: skip

    def lack_of_windows(self, records: RecordBatch) -> str | None:
        """Message if records are too short for a balance, else None."""
        n_window = records.n_time // self.half_window - 1
        return f"{max(n_window, 0)} windows are too few for a balance" if n_window < 8 else None


TAKEN_UP, TAKEN_UP_BY_SPRING = 0.1, 0.6
"""Share of a change of the clearance that K_i takes up, at most: on leaky valves of real-rig 0.03 with a
position sensor and 0.57 without."""


@cache
def balance_outputs(reference_pressure: float, taken_up: float = TAKEN_UP) -> tuple[Output, ...]:
    """Outputs of a volume balance, with the leakage at a reference pressure difference [Pa]."""
    at, rising = f"at {reference_pressure / 1e6:g} MPa", Direction.RISING
    return (
        Output(
            "internal_coefficient", "m^3.5/kg^0.5", "coefficient K_i of the internal leakage",
            direction=rising, is_score=False,
        ),
        Output.quality("internal_coefficient_error", "m^3.5/kg^0.5", "standard deviation of K_i"),
        Output(
            "leakage", "m^3/s", f"internal leakage flow of K_i {at}", direction=rising, possible=POSITIVE,
            error="leakage_error", clearances=("cross_port_leakage", taken_up),
        ),
        Output.quality("leakage_error", "m^3/s", "standard deviation of the flow of K_i"),
        Output(
            "mean_leakage", "m^3/s", "mean flow across piston and closed valve, for any leakage law",
            direction=rising,
        ),
        Output.quality("mean_leakage_error", "m^3/s", "standard deviation of the mean flow of the piston"),
        Output(
            "cross_port_leakage", "m^3/s", f"flow across piston and closed valve, for any leakage law, {at}",
            direction=rising,
        ),
        Output.quality("cross_port_leakage_error", "m^3/s", "standard deviation of the flow across both"),
        Output("bulk_modulus", "Pa", "effective bulk modulus β at half the supply pressure", possible=FLUID),
        Output.quality("bulk_modulus_error", "Pa", "standard deviation of β"),
        Output(
            "flow_gain", "1", "flow gain of the valve relative to its nominal value",
            is_score=False, possible=POSITIVE,
        ),
        Output("supply_pressure", "Pa", "supply pressure", is_score=False, possible=POSITIVE),
        Output("offset", "m", "spool position at which the valve is closed", is_score=False),
        Output("lap", "m", "lap of the valve", is_score=False),
        Output(
            "clearance", "m^3/(s*Pa)", "conductance of the clearance at a valve edge",
            is_score=False,
        ),
        Output.quality("condition", "1", "condition number of the equations including the prior"),
        Output.quality("flow_gain_error", "1", "standard deviation of the relative flow gain"),
        Output.quality("supply_pressure_error", "Pa", "standard deviation of the supply pressure"),
        Output.quality("offset_error", "m", "standard deviation of the offset"),
        Output.quality("lap_error", "m", "standard deviation of the lap"),
        Output.quality("clearance_error", "m^3/(s*Pa)", "standard deviation of the clearance"),
        Output(
            "misfit", "1", "RMS of the residuals of the balances, over the option 'error'",
            is_score=False, possible=(0.0, FITS), is_fit=True,
        ),
        Output(
            "departure", "1", "largest deviation of an unknown from the data sheet, over its prior deviation",
            is_score=False, possible=(0.0, 3.0), is_fit=True,
        ),
        Output(
            "disagreement", "1", "difference between the K_i of each chamber alone, over its deviation",
            is_score=False, possible=(0.0, 2.0), is_fit=True,
        ),
    )  # fmt: skip


def named_estimates(
    options: WindowOptions, estimates: Array, reference: Array, deviations: Array
) -> dict[str, Array]:
    """`balance_outputs` from estimates (n_record, n_instant, N_ESTIMATE).

    `reference`: supply pressure that the estimates are relative to [Pa]; `deviations`: of the priors.
    """
    names, of_index = chamber_balance.UNKNOWNS, np.moveaxis(estimates, 2, 0)
    of = dict(zip(names, of_index[: len(names)], strict=True))
    error = dict(zip(names, of_index[len(names) : 2 * len(names)], strict=True))
    root = math.sqrt(options.reference_pressure)
    # At its bound, the compressibility is zero but for rounding, whose sign says nothing.
    compressibility = 1.0 / options.bulk_modulus + of["compressibility"]
    modulus = 1.0 / np.maximum(compressibility, 1e-9 / options.bulk_modulus)
    sheet = [i for i, name in enumerate(names) if deviations[i] > 0.0 and name not in _FREE]
    values = {
        "leakage": root * of["internal_coefficient"],
        "leakage_error": root * error["internal_coefficient"],
        "bulk_modulus": modulus,
        "bulk_modulus_error": options.bulk_modulus_error(modulus, error["compressibility"] * modulus**2),
        "flow_gain": 1.0 + of["flow_gain"],
        "flow_gain_error": error["flow_gain"],
        "supply_pressure": reference * (1.0 + of["supply"]),
        "supply_pressure_error": reference * error["supply"],
        "departure": np.max(np.abs(estimates[:, :, sheet]) / deviations[sheet], axis=2, initial=0.0),
    }
    for name in ("internal_coefficient", "offset", "lap", "clearance"):
        values |= {name: of[name], f"{name}_error": error[name]}
    return values | {name: of_index[index] for name, index in _AS_FOUND.items()}


_AS_FOUND = {
    "mean_leakage": weak_rls.MEAN, "mean_leakage_error": weak_rls.MEAN_ERROR,
    "cross_port_leakage": weak_rls.COMBINED, "cross_port_leakage_error": weak_rls.COMBINED_ERROR,
    "condition": weak_rls.CONDITION, "misfit": weak_rls.MISFIT, "disagreement": weak_rls.DISAGREEMENT,
}  # fmt: skip
"""Output → index of an estimate."""

_FREE = ("internal_coefficient", "supply")
"""Unknowns that no data sheet states well."""


def counting_windows(spool: Array, frequency: float, options: WindowOptions) -> Array:
    """1 for windows with the valve open to one side and without a jump, else 0; (n_record, n_window)."""
    # The trapezoidal rule fails at a jump and at a kink, such as that of a spool that lags a jump.
    change = np.diff(spool, axis=1, prepend=spool[:, :1])
    bend = np.diff(change, axis=1, prepend=change[:, :1])
    sudden = np.minimum(np.abs(change), np.abs(bend))
    # Noise bends the spool everywhere.
    least = np.maximum(0.05 * np.ptp(spool, axis=1), 8.0 * np.median(sudden, axis=1))
    jumps = sudden > least[:, None]
    unclear = unclear_samples(spool, jumps, round(options.settling * frequency), options.least_opening)
    return clear_windows(unclear, options.half_window)
