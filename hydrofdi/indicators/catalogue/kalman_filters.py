"""Internal leakage as a state of Kalman filters, and from the innovations of one without leakage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import model_validator

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators import kalman_filter
from hydrofdi.indicators.balancing import balance_outputs
from hydrofdi.indicators.contract import Output, Trace
from hydrofdi.indicators.estimation.plant import STATES
from hydrofdi.records import Array
from hydrofdi.settings.quantities import SI

_OF_PRIOR = 0.9
"""Share of its prior standard deviation above which an estimate says nothing of a record."""

_LARGEST_NIS = 25.0
"""Innovations five times as large as assumed; those of machines with hoses and an elastic frame reach 20."""


class JointOptions(kalman_filter.KalmanOptions):
    """Options of filters that estimate the leakage jointly with the motion."""

    @model_validator(mode="after")
    def _leakage_is_estimated(self) -> JointOptions:
        if "leakage" not in self.states:
            raise ValueError("states must contain leakage")
        return self


class EkfJoint(kalman_filter.KalmanFilter[JointOptions]):
    """Internal leakage, bulk modulus and valve parameters as states of an extended Kalman filter."""

    name = "ekf_joint"
    version = 3
    source = (
        "An & Sepehri, Int. J. Fluid Power 6(2) (2005); Sepasi & Sassani, IJCAS 8 (2010); considered"
        " parameters: Schmidt, Advances in Control Systems 3 (1966)"
    )
    equation = (
        "(P_1, P_2, x_p, v_p, F, q_i, ln β, ln P_s, gain, offset, lap, clearance, biases) by the equations"
        " of the actuator, Runge-Kutta and its exact derivative; corrected by P_1, P_2 and x_p"
    )
    caution = (
        "β is biased by up to −1 %; of its stated deviation only chamber_volume_deviation covers this. The"
        " standard deviation of the leakage is too wide for the nominal plant and about right for machines"
        " that differ from it by these parameters alone. Channels that are 2 ms apart, a spool of 80 Hz for"
        " 175 Hz or its rate limit shift the leakage by 0.1 L/min: prefer weak_rls, whose windows integrate"
        " over such lags."
    )
    absence = "the filter diverged, a sample is not a number, or the record does not determine the leakage"
    Options = JointOptions

    @property
    def estimates(self) -> tuple[Output, ...]:
        """The leakage first, then the other estimated parameters."""
        kept = {each.name: each for each in balance_outputs(self.options.reference_pressure)}
        chosen = self.options.states
        return (
            replace(kept["leakage"], possible=(None, None), error=""),
            *(kept[name] for name in ("leakage_error", "internal_coefficient", "internal_coefficient_error")),
            *(kept[name] for state, names in _AUXILIARY.items() if state in chosen for name in names),
            replace(
                Output.quality("nis", "1", "mean normalised innovation squared; 1 with the assumed noise"),
                possible=(None, _LARGEST_NIS),
                is_fit=True,
            ),
        )

    def read(self, estimates: kalman_filter.FilterEstimates) -> Mapping[str, Array]:
        """Estimates in SI, each (n_record, n_instant)."""
        mean = {name: estimates.means[:, :, index] for index, name in enumerate(STATES)}
        error = {name: np.sqrt(estimates.variances[:, :, index]) for index, name in enumerate(STATES)}
        options, per_root = self.options, 1.0 / np.sqrt(self.options.reference_pressure)
        modulus = options.bulk_modulus * np.exp(mean["bulk_modulus"])
        leakage, leakage_error = (
            kalman_filter.LITRE_PER_MINUTE * mean["leakage"],
            kalman_filter.LITRE_PER_MINUTE * error["leakage"],
        )
        values = {
            "leakage": leakage,
            "leakage_error": leakage_error,
            "internal_coefficient": per_root * leakage,
            "internal_coefficient_error": per_root * leakage_error,
            "bulk_modulus": modulus,
            "bulk_modulus_error": options.bulk_modulus_error(modulus, modulus * error["bulk_modulus"]),
            "supply_pressure": 1e6 * estimates.supply * np.exp(mean["supply"]),
            "flow_gain": 1.0 + mean["flow_gain"],
            "offset": 1e-6 * mean["offset"],
            "lap": 1e-6 * mean["lap"],
            "clearance": 1e-15 * mean["clearance"],
            "nis": estimates.sums[:, :, 0] / (3 * estimates.n_sample),
        }
        return {each.name: values[each.name] for each in self.estimates}

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """The last estimates, and the mean nis; none if the record hardly reduces the prior deviation."""
        last = {name: values[:, -1] for name, values in trace.values.items()}
        is_prior = last["leakage_error"] > _OF_PRIOR * self.options.leakage_deviation
        last["nis"] = trace.values["nis"].mean(axis=1)
        return {name: np.where(is_prior, np.nan, values) for name, values in last.items()}


_AUXILIARY = {
    "bulk_modulus": ("bulk_modulus", "bulk_modulus_error"),
    "supply": ("supply_pressure",),
    **{name: (name,) for name in ("flow_gain", "offset", "lap", "clearance")},
}


class UnscentedOptions(JointOptions):
    """Options of `UkfJoint`."""

    spread: Annotated[float, SI("1", above=0, most=1)] = 1.0
    """Spread α of the sigma points about the mean, in √n standard deviations for n states [-]; with 0.001 it
    is nearly an extended filter."""


class UkfJoint(EkfJoint):
    """Internal leakage, bulk modulus and valve parameters as states of a square-root unscented Kalman
    filter.
    """

    name = "ukf_joint"
    version = 3
    source = (
        "van der Merwe & Wan, ICASSP (2001); leakage: Sepasi & Sassani, IJCAS 8 (2010); Liu, Proc. Inst."
        " Mech. Eng. I 228 (2014)"
    )
    equation = "states and measurements of ekf_joint; mean and covariance from 2n + 1 points, P = S Sᵀ"
    Options = UnscentedOptions


class InnovationOptions(kalman_filter.KalmanOptions):
    """Options of a filter of the healthy plant."""

    states: tuple[kalman_filter.Parameter, ...] = ()
    """Parameters estimated in addition to both pressures, position, velocity and friction, such as
    ``supply``; the others are nominal."""

    pressure_noise: Annotated[float, SI("Pa", above=0)] = 5.3e3
    """Standard deviation of the noise of each pressure sensor [Pa]; 5 kPa plus 12-bit quantisation."""

    @model_validator(mode="after")
    def _leakage_is_not_estimated(self) -> InnovationOptions:
        if "leakage" in self.states:
            raise ValueError("states must not contain leakage; use ekf_joint to estimate it")
        return self


class EkfInnovation(kalman_filter.KalmanFilter[InnovationOptions]):
    """Innovations of an extended Kalman filter of the healthy actuator, and the leakage estimated from
    them.
    """

    name = "ekf_innovation"
    version = 2
    source = (
        "An & Sepehri, Proc. American Control Conference (2003) and Int. J. Fluid Power 6(2) (2005);"
        " signature of a fault: Friedland, IEEE Trans. Automatic Control 14 (1969), and Willsky & Jones,"
        " ibid. 21 (1976)"
    )
    equation = (
        "leakage = Σ d ν/s / Σ d²/s over the innovations ν with variance s, d the innovation that a leak of"
        " one unit from the start on would add; nis = mean ν²/s"
    )
    caution = (
        "Innovations respond to any deviation from the data sheet, such as friction, supply pressure and"
        " flow gain, before they respond to a leak; so do lags between channels and a slower spool."
    )
    Options = InnovationOptions

    @property
    def estimates(self) -> tuple[Output, ...]:
        """The leakage from its signature first, then the magnitude of the innovations."""
        at, rising = f"at {self.options.reference_pressure / 1e6:g} MPa", Direction.RISING
        return (
            Output("leakage", "m^3/s", f"leakage flow whose signature fits {at}", direction=rising),
            Output.quality(
                "leakage_error", "m^3/s", "standard deviation of that flow, widened by √nis if nis exceeds 1"
            ),
            Output("nis", "1", "mean normalised innovation squared", direction=rising),
            Output("residual", "Pa", "root mean square innovation of the pressures", direction=rising),
        )

    def read(self, estimates: kalman_filter.FilterEstimates) -> Mapping[str, Array]:
        """Values in SI; an interval without information about a leak has an infinite error.

        ``error_of_model`` is the standard deviation under the assumption of the nominal plant.
        """
        squares, pressures, fits, weights = np.moveaxis(estimates.sums, 2, 0)
        shows = weights > 0.0
        safe = np.where(shows, weights, 1.0)
        error = kalman_filter.LITRE_PER_MINUTE * np.where(shows, 1.0 / np.sqrt(safe), np.inf)
        nis = squares / (3 * estimates.n_sample)
        return {
            "leakage": kalman_filter.LITRE_PER_MINUTE * np.where(shows, fits / safe, 0.0),
            "leakage_error": error * _deviation_factor(nis),
            "error_of_model": error,
            "nis": nis,
            "residual": 1e6 * np.sqrt(pressures / (2 * estimates.n_sample)),
        }

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """Mean innovations, and the leakage that fits all of them."""
        weights = 1.0 / trace.values["error_of_model"] ** 2
        total = np.sum(weights, axis=1)
        nis = np.mean(trace.values["nis"], axis=1)
        return {
            "leakage": np.sum(weights * trace.values["leakage"], axis=1) / total,
            "leakage_error": np.where(total > 0.0, _deviation_factor(nis) / np.sqrt(total), np.nan),
            "nis": nis,
            "residual": np.sqrt(np.mean(trace.values["residual"] ** 2, axis=1)),
        }


def _deviation_factor(nis: Array) -> Array:
    """Factor, at least 1, by which the standard deviations of a model are too small."""
    return np.sqrt(np.maximum(nis, 1.0))
