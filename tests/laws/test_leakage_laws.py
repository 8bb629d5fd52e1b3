"""Laws of leakage, seen through the simulation."""

from __future__ import annotations

import numpy as np
import pytest
from free_motion import free_motion

HELD = {"actuator.mass": 1e18}
"""A piston so heavy that it does not move."""


@pytest.mark.parametrize("coefficient", [1e-10, 1e-9])
@pytest.mark.parametrize("bulk_modulus", [551e6, 827e6])
def test_shut_valve_lets_the_root_of_the_pressure_difference_fall_linearly_to_zero(
    coefficient: float, bulk_modulus: float
) -> None:
    difference, volume = 4e6, 280e-6
    end = volume * np.sqrt(difference) / (bulk_modulus * coefficient)
    values = HELD | {"leakage.internal_coefficient": coefficient, "fluid.bulk_modulus": bulk_modulus}
    start = {"pressure_1": 8.6e6 + difference / 2, "pressure_2": 8.6e6 - difference / 2}
    n_step = 2000
    motion = free_motion([values], [start], [0.0], 0.95 * end, 0.95 * end / n_step)
    root = np.sqrt(motion["pressure_1"] - motion["pressure_2"])[0]
    time = np.arange(n_step) * 0.95 * end / n_step
    np.testing.assert_allclose(root, np.sqrt(difference) * (1.0 - time / end), rtol=1e-7)


def test_shut_valve_lets_an_external_leak_empty_each_chamber_exponentially() -> None:
    coefficient, rate = 2e-12, 551e6 * 2e-12 / 280e-6
    start = {"pressure_1": 9e6, "pressure_2": 5e6}
    motion = free_motion([HELD | {"leakage.external_coefficient": coefficient}], [start], [0.0], 0.2, 1e-4)
    decay = np.exp(-rate * 1e-4 * np.arange(2000))
    np.testing.assert_allclose(motion["pressure_1"][0], 9e6 * decay, rtol=1e-6)
    np.testing.assert_allclose(motion["pressure_2"][0], 5e6 * decay, rtol=1e-6)


def test_sealed_cylinder_with_a_shut_valve_keeps_its_pressures() -> None:
    start = {"pressure_1": 9e6, "pressure_2": 5e6}
    motion = free_motion([HELD], [start], [0.0], 0.1, 1e-4)
    np.testing.assert_allclose(motion["pressure_1"][0], 9e6, rtol=1e-9)
    np.testing.assert_allclose(motion["pressure_2"][0], 5e6, rtol=1e-9)
