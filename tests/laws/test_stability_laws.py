"""The stability limits predict what the kernel does."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from free_motion import free_motion
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.api.step_limits import step_limits
from hydrofdi.config import RunParameters
from hydrofdi.physics.hydraulic_mode import amplification, largest_stable_step
from hydrofdi.simulation.batch import simulate_batch

FREE = {"actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.0}
"""Nothing but friction acts on the piston."""


@pytest.mark.parametrize(("share", "grows"), [(0.97, False), (1.03, True)])
def test_friction_zone_turns_unstable_at_its_limit(share: float, grows: bool) -> None:
    step = share * step_limits(lambda *_: [RunParameters()])["friction zone"]
    motion = free_motion([FREE], [{"velocity": 1e-6}], [0.0], 100 * step, step)
    assert (abs(motion["velocity"][0, -1]) > 1e-6) == grows


@pytest.mark.parametrize(("share", "grows"), [(0.98, False), (1.02, True)])
def test_hydraulic_mode_turns_unstable_at_its_limit(share: float, grows: bool) -> None:
    values = {f"friction.{name}": 0.0 for name in ("coulomb", "breakaway", "viscous")}
    step = share * step_limits(lambda *_: [RunParameters().with_values(values)])["hydraulic mode"]
    motion = free_motion([values], [{"velocity": 1e-6}], [0.0], 300 * step, step)
    assert (np.abs(motion["velocity"][0, -20:]).max() > 1e-6) == grows


@given(st.floats(min_value=math.pi / 2, max_value=math.pi), st.floats(min_value=0.01, max_value=1e5))
def test_no_step_below_the_limit_amplifies(angle: float, size: float) -> None:
    eigenvalue = size * complex(math.cos(angle), math.sin(angle))
    limit = largest_stable_step(eigenvalue)
    factors = [abs(amplification(share * limit * eigenvalue)) for share in (0.25, 0.5, 0.75, 0.999)]
    assert max(factors) <= 1.0 + 1e-9
    assert abs(amplification(1.001 * limit * eigenvalue)) > 1.0


STIFF: dict[str, tuple[str, dict[str, Any], float, float]] = {
    "clearance": ("leakage of the chambers", {"valve.lap_leakage": 1e-8}, 0.05e-3, 0.1e-3),
    "external": ("leakage of the chambers", {"leakage.external_coefficient": 1e-8}, 0.1e-3, 0.2e-3),
    "bristles": ("bristles", {"friction.law": "lugre", "friction.bristle_damping": 1e5}, 0.1e-3, 0.4e-3),
    "supply": (
        "supply",
        {
            "supply.droop": "first_order", "supply.droop_time_constant": 5e-3, "valve.lap_leakage": 1e-9,
            "friction.law": "smooth", "friction.scale": 0.01,
        },
        0.2e-3, 0.4e-3,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", STIFF)
def test_a_stiff_part_holds_below_its_step_limit_and_diverges_above(name: str) -> None:
    part, values, good, bad = STIFF[name]
    base = RunParameters().with_values({"record.duration": 2.0, "record.sampling_frequency": 250.0, **values})
    runs = [base.with_values({"record.step": step}) for step in (good, bad)]
    assert good < step_limits(lambda *_: [base])[part] < bad
    assert [simulate_batch([run], [0.0]).outcomes[0].status for run in runs] == ["ok", "diverged"]
