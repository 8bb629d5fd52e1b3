"""Jobs that all contestants solve, and the RMS of d2 for comparing accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.simulation.inputs import input_voltage
from hydrofdi.simulation.lanes import WIDTH, pack_singles
from hydrofdi.transforms import WaveletConfig, detail_rms

LARGEST_LEAKAGE_COEFFICIENT = 2.0e-8
"""K_i [m^3.5/kg^0.5] that leaks about 2 L/min."""

PAPER_FIELDS = (
    "mass", "area", "volume", "stiffness", "rated_supply", "ret", "bulk_modulus", "flow_gain",
    "area_gradient", "coulomb", "breakaway", "viscous", "transition", "velocity_threshold",
    "internal_leakage", "external_leakage_1", "spool_frequency", "spool_damping_ratio", "spool_gain",
)  # fmt: skip
"""Lane fields of the paper's model."""

Job = tuple[RunParameters, float]
"""A run and its K_i."""


AT_REST = {"input.period": 100.0}
"""Input that is constant over any record, so that the motion comes to rest."""

IN_MOTION = {"input.shape": "steps", "input.period": 0.02}
"""Input that changes before the motion comes to rest."""


def lane_jobs(
    duration: float, *, drives: int = 1, values: Mapping[str, Any] = MappingProxyType({})
) -> list[Job]:
    """Jobs for all lanes, over leakage and bulk modulus, with the given number of different drives."""
    amplitudes = np.linspace(1.5, 2.0, drives) if drives > 1 else [2.0]
    nominal = RunParameters().with_values({"record.duration": duration, **values})
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
    """Parameters of a job in the order of ``PAPER_FIELDS``, in SI."""
    parameters, leakage_coefficient = job
    single = pack_singles([parameters], [leakage_coefficient])[0]
    return np.array([single[field][0] for field in PAPER_FIELDS])


@cache
def voltage(parameters: RunParameters, refinement: int = 1) -> np.ndarray:
    """Input of every Runge-Kutta step [V], with the step divided by `refinement`."""
    steps = np.arange(parameters.record.n_step)
    return np.repeat(input_voltage(parameters.input, parameters.record, steps), refinement)


def d2_rms(pressure: np.ndarray) -> float:
    """RMS of detail d2 of a chamber-1 pressure [Pa]."""
    return float(detail_rms(pressure, WaveletConfig())[1])
