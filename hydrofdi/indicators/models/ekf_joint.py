"""Internal leakage as a state of an extended Kalman filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from pydantic import model_validator

from hydrofdi.indicators.balancing import balance_outputs
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.estimation.plant import STATES
from hydrofdi.indicators.kalman_filter import LITRE_PER_MINUTE, Estimates, KalmanFilter, KalmanOptions
from hydrofdi.indicators.recursive import Trace
from hydrofdi.records import Array

_LARGEST_NIS = 25.0
"""Innovations five times as large as assumed; those of machines with hoses and an elastic frame reach 20."""


class JointOptions(KalmanOptions):
    """Options of filters that estimate the leakage jointly with the motion."""

    @model_validator(mode="after")
    def _leakage_is_estimated(self) -> JointOptions:
        if "leakage" not in self.states:
            raise ValueError("states must contain leakage")
        return self


class EkfJoint(KalmanFilter[JointOptions]):
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
    def prior_deviation(self) -> float:
        """Prior standard deviation of the leakage [m³/s]."""
        return self.options.leakage_deviation

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

    def read(self, found: Estimates) -> Mapping[str, Array]:
        """Estimates in SI, each (n_record, n_instant)."""
        mean = {name: found.means[:, :, place] for place, name in enumerate(STATES)}
        error = {name: np.sqrt(found.variances[:, :, place]) for place, name in enumerate(STATES)}
        options, per_root = self.options, 1.0 / np.sqrt(self.options.reference_pressure)
        modulus = options.bulk_modulus * np.exp(mean["bulk_modulus"])
        leakage, leakage_error = LITRE_PER_MINUTE * mean["leakage"], LITRE_PER_MINUTE * error["leakage"]
        values = {
            "leakage": leakage,
            "leakage_error": leakage_error,
            "internal_coefficient": per_root * leakage,
            "internal_coefficient_error": per_root * leakage_error,
            "bulk_modulus": modulus,
            "bulk_modulus_error": options.bulk_modulus_error(modulus, modulus * error["bulk_modulus"]),
            "supply_pressure": 1e6 * found.supply * np.exp(mean["supply"]),
            "flow_gain": 1.0 + mean["flow_gain"],
            "offset": 1e-6 * mean["offset"],
            "lap": 1e-6 * mean["lap"],
            "clearance": 1e-15 * mean["clearance"],
            "nis": found.sums[:, :, 0] / (3 * found.n_sample),
        }
        return {each.name: values[each.name] for each in self.estimates}

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """The last estimates, and the mean of the quality measures."""
        means = {"nis"}
        return {
            name: values.mean(axis=1) if name in means else values[:, -1]
            for name, values in trace.values.items()
        }


_AUXILIARY = {
    "bulk_modulus": ("bulk_modulus", "bulk_modulus_error"),
    "supply": ("supply_pressure",),
    **{name: (name,) for name in ("flow_gain", "offset", "lap", "clearance")},
}
