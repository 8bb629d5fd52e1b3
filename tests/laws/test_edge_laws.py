"""Laws of metering edges that differ from each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from free_motion import free_motion

from hydrofdi.api.step_limits import step_limits
from hydrofdi.config import RunParameters
from hydrofdi.config.request import EDGES
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.drive import largest_opening

SHORT = RunParameters().with_values({"record.duration": 1.0, "input.period": 0.5})
LAPPED = {"valve.lap": -1e-6, "valve.lap_leakage": 2e-14}
STARTS = {"pressure_1": 5e6, "pressure_2": 9e6}
FREE = {"actuator.load_stiffness": 0.0}


def _of_every_edge(**values: float) -> dict[str, float]:
    return {f"{edge}.{name}": value for edge in EDGES for name, value in values.items()}


def test_what_all_edges_have_of_their_own_is_what_the_valve_has() -> None:
    """Lap and clearance add up, gains multiply."""
    own = _of_every_edge(lap=-1e-6, lap_leakage=2e-14, flow_gain_ratio=0.5)
    gain = RunParameters().valve.flow_gain
    runs = [SHORT.with_values(own), SHORT.with_values(LAPPED | {"valve.flow_gain": 0.5 * gain})]
    batch = simulate_batch(runs, [2e-9, 2e-9])
    np.testing.assert_array_equal(batch.chamber_1_pressure[0], batch.chamber_1_pressure[1])
    np.testing.assert_array_equal(batch.piston_position[0], batch.piston_position[1])


@pytest.mark.parametrize(
    ("edge", "opening"),
    [("supply_1_edge", 1), ("return_1_edge", -1), ("supply_2_edge", -1), ("return_2_edge", 1)],
)
@pytest.mark.parametrize("values", [{"lap": 3e-6}, {"flow_gain_ratio": 0.7}], ids=["lap", "gain"])
def test_an_edge_acts_where_it_is_open_alone(edge: str, opening: int, values: dict[str, float]) -> None:
    own = {f"{edge}.{name}": value for name, value in values.items()}
    for side in (1, -1):
        motion = free_motion([FREE | own, FREE], [{}, {}], [side * 20e-6] * 2, 0.1, 1e-4)
        differs = np.ptp(motion["position"][0] - motion["position"][1]) > 1e-5
        assert differs == (side == opening)


@pytest.mark.parametrize(("edge", "end"), [("supply", 17.2e6), ("return", 0.0)])
@pytest.mark.parametrize("chamber", [1, 2])
def test_clearance_of_an_edge_brings_its_chamber_to_what_lies_behind(
    edge: str, chamber: int, end: float
) -> None:
    """A shut valve with one clearance: the chamber goes to supply or return with V/(β c_lap)."""
    values = FREE | {"valve.lap": 5e-6, "fluid.bulk_modulus": 551e6, "actuator.mass": 1e12}
    values |= {f"{edge}_{chamber}_edge.lap_leakage": 5e-13}
    motion = free_motion([values], [{"pressure_1": 5e6, "pressure_2": 5e6}], [0.0], 1.0, 1e-4)
    time = 1e-4 * np.arange(motion["pressure_1"].shape[1])
    expected = end + (5e6 - end) * np.exp(-time * 551e6 * 5e-13 / 280e-6)
    np.testing.assert_allclose(motion[f"pressure_{chamber}"][0], expected, rtol=1e-6, atol=10.0)
    assert np.ptp(motion[f"pressure_{3 - chamber}"][0]) < 10.0


def test_bounds_follow_the_edge_that_goes_farthest() -> None:
    far = SHORT.with_values({"return_2_edge.lap": -3e-6, "supply_1_edge.lap": 5e-6})
    assert largest_opening(far) == pytest.approx(largest_opening(SHORT) + 3e-6)
    part, values = "leakage of the chambers", _of_every_edge(lap_leakage=1e-9)
    all_four, common, one = (
        step_limits(lambda *_, run=run: [run])[part]
        for run in map(
            SHORT.with_values, (values, {"valve.lap_leakage": 1e-9}, {"return_2_edge.lap_leakage": 2e-9})
        )
    )
    assert all_four == common == one


def test_edges_leave_the_identity_of_other_runs_alone() -> None:
    equal: dict[str, Any] = _of_every_edge(lap=0.0, lap_leakage=0.0, flow_gain_ratio=1.0)
    assert SHORT.with_values(equal).text() == SHORT.text()
    assert SHORT.with_values({"supply_1_edge.lap": 1e-6}).text() != SHORT.text()
