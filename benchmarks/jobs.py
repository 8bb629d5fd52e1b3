"""The jobs that all contestants solve, and how good their d2 is."""

from __future__ import annotations

from functools import cache

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.config.wavelet import WaveletConfig
from hydrofdi.features import detail_rms
from hydrofdi.simulation.drive import input_voltage
from hydrofdi.simulation.lanes import PARAMETERS, WIDTH

LARGEST_LEAKAGE_COEFFICIENT = 2.0e-8
"""K_i [m^3.5/kg^0.5] that leaks about 2 L/min."""

Job = tuple[RunParameters, float]
"""A run and its K_i."""


def lane_jobs(duration: float, *, drives: int = 1) -> list[Job]:
    """As many jobs as there are lanes, over leakage and bulk modulus, with so many different drives."""
    amplitudes = np.linspace(1.5, 2.0, drives) if drives > 1 else [2.0]
    nominal = RunParameters().with_values({"run.duration": duration})
    moduli = np.linspace(551e6, 827e6, WIDTH)
    leakages = np.linspace(0.0, LARGEST_LEAKAGE_COEFFICIENT, 8)
    return [
        (
            nominal.with_values(
                {"fluid.bulk_modulus": float(moduli[k]), "input.amplitude": float(amplitudes[k % drives])}
            ),
            float(leakages[k % 8]),
        )
        for k in range(WIDTH)
    ]


def parameter_vector(job: Job) -> np.ndarray:
    """The paper's parameters of a job in the order of the lanes, then ω_v [rad/s], ξ and k_v [m/V]."""
    parameters, leakage_coefficient = job
    valve = parameters.valve
    fields = list(PARAMETERS)[: list(PARAMETERS).index("external_leakage_2")]  # those of the paper's model
    values = [parameters.value(PARAMETERS[field]) for field in fields]
    values[fields.index("internal_leakage")] = leakage_coefficient
    spool = [2.0 * np.pi * valve.natural_frequency, valve.damping_ratio, valve.spool_gain]
    return np.array([*values, *spool], dtype=float)


@cache
def voltage(parameters: RunParameters, refinement: int = 1) -> np.ndarray:
    """Input of every Runge-Kutta step [V], the step being divided by `refinement`."""
    steps = np.arange(parameters.run.n_step)
    return np.repeat(input_voltage(parameters.input, parameters.run, steps), refinement)


def d2_rms(pressure: np.ndarray) -> float:
    """RMS of d2 of a chamber-1 pressure [Pa]."""
    return float(detail_rms(pressure, WaveletConfig())[1])
