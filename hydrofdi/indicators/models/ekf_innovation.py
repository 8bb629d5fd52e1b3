"""Internal leakage from the innovations of an extended Kalman filter that models no leakage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import model_validator

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.kalman_filter import (
    LITRE_PER_MINUTE,
    Estimates,
    KalmanFilter,
    KalmanOptions,
    Parameter,
)
from hydrofdi.indicators.recursive import Trace
from hydrofdi.records import Array
from hydrofdi.settings.quantities import SI


class InnovationOptions(KalmanOptions):
    """Options of a filter of the healthy plant."""

    states: tuple[Parameter, ...] = ()
    """Parameters estimated in addition to both pressures, position, velocity and friction, such as
    ``supply``; the others are nominal."""

    pressure_noise: Annotated[float, SI("Pa", above=0)] = 5.3e3
    """Standard deviation of the noise of each pressure sensor [Pa]; 5 kPa plus 12-bit quantisation."""

    @model_validator(mode="after")
    def _leakage_is_not_estimated(self) -> InnovationOptions:
        if "leakage" in self.states:
            raise ValueError("states must not contain leakage; use ekf_joint to estimate it")
        return self


class EkfInnovation(KalmanFilter[InnovationOptions]):
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

    def read(self, found: Estimates) -> Mapping[str, Array]:
        """Values in SI; an interval without information about a leak has an infinite error.

        ``error_of_model`` is the standard deviation under the assumption of the nominal plant.
        """
        squares, pressures, fits, weights = np.moveaxis(found.sums, 2, 0)
        shows = weights > 0.0
        safe = np.where(shows, weights, 1.0)
        error = LITRE_PER_MINUTE * np.where(shows, 1.0 / np.sqrt(safe), np.inf)
        nis = squares / (3 * found.n_sample)
        return {
            "leakage": LITRE_PER_MINUTE * np.where(shows, fits / safe, 0.0),
            "leakage_error": error * _deviation_factor(nis),
            "error_of_model": error,
            "nis": nis,
            "residual": 1e6 * np.sqrt(pressures / (2 * found.n_sample)),
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
