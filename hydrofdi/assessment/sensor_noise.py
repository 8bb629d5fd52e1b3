"""Noise of the chamber-1 pressure sensor against what the detail RMS have to show."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.config.request import RunRequest
from hydrofdi.sensing import noise_autocovariance, quantisation_noise
from hydrofdi.transforms.wavelet import noise_rms

MUCH_NOISE = 0.1
"""Noise above this share of a level's RMS is warned of; it adds half a percent to that RMS."""


@dataclass(frozen=True)
class NoiseOfLevel:
    """One level of the chamber-1 pressure.

    Attributes
    ----------
    noise : float
        RMS of the detail coefficients of the sensor's noise, as the anti-alias filter leaves it, and of
        quantisation, of the noisiest run [Pa].
    weakest_rms : float
        Least detail RMS of the pressure itself over the runs that ended well [Pa]; NaN if none did.
    """

    noise: float
    weakest_rms: float

    @property
    def share(self) -> float:
        """Noise over the least RMS [-]."""
        return self.noise / self.weakest_rms if self.weakest_rms else math.inf


def noise_of_levels(
    runs: Iterable[RunRequest], rows: Sequence[Mapping[str, Any]]
) -> tuple[NoiseOfLevel, ...]:
    """Noise and signal of each level, d1 first; empty if no run has a noisy sensor.

    Parameters
    ----------
    runs : iterable of RunRequest
        Whose sensors are looked at.
    rows : sequence of dict
        Variables of simulated runs with ideal sensors.
    """
    noises = {(run.wavelet, _autocovariance(run)) for run in runs}
    if not any(noise[0] for _, noise in noises):
        return ()
    levels = min(wavelet.levels for wavelet, _ in noises)
    noisiest = np.max([noise_rms(wavelet, noise)[:levels] for wavelet, noise in noises], axis=0)
    signals = np.array([row["detail_rms"][:levels] for row in rows if row["status"] == "ok"])
    weakest = signals.min(axis=0) if len(signals) else np.full(levels, np.nan)
    return tuple(NoiseOfLevel(float(noisiest[level]), float(weakest[level])) for level in range(levels))


def _autocovariance(run: RunParameters) -> tuple[float, ...]:
    """Autocovariance of noise and quantisation in the chamber-1 pressure [Pa²]."""
    sensor = run.pressure_1_sensor
    variance, *others = noise_autocovariance(sensor, run.measurement, run.record)
    return variance + quantisation_noise(sensor.resolution) ** 2, *others
