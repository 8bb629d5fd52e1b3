"""Noise of the position that a controller reads."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.sensing.channels import random_generator
from hydrofdi.sensing.noise import gaussian_noise, noise_autocovariance
from hydrofdi.simulation.inputs import steps_per_control

LOOP = "position_feedback"
"""Random source of the noise in the loop at instants that are not sampled."""


def feedback_noise(run: RunParameters) -> NDArray[np.float64] | None:
    """White noise of the position at the samples of the controller of a run.

    Its variance is that of a record sampled at the rate of the controller, without the anti-alias filter. At
    instants that the record samples too, both have the same noise, if the noise of the record is white with
    the same variance and there is no jitter.

    Returns
    -------
    ndarray, shape (n_control,), or None
        [m]; None if there is no noise.
    """
    sensor, record, shared = run.position_sensor, run.record, run.measurement
    own_rate = record.model_copy(update={"sampling_frequency": 1.0 / run.control.sample_time})
    unfiltered = shared.model_copy(update={"anti_alias": None})
    (variance,) = noise_autocovariance(sensor, unfiltered, own_rate)
    if not run.control.is_measured or variance == 0.0:
        return None
    steps = np.arange(0, record.n_step, steps_per_control(run))
    noise = gaussian_noise((variance,), steps.size, random_generator(run, LOOP))
    recorded = noise_autocovariance(sensor, shared, record)
    if len(recorded) == 1 and math.isclose(recorded[0], variance) and shared.jitter == 0.0:
        sampled = steps % record.steps_per_sample == 0
        samples = gaussian_noise(recorded, record.n_sample, random_generator(run, "position_sensor"))
        noise[sampled] = samples[steps[sampled] // record.steps_per_sample]
    return noise
