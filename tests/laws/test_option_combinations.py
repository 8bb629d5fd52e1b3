"""Options of the model, alone and together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.simulation.balances import balance_residuals
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.kernels.lanes import HALF_WIDTH

SHORT = RunParameters().with_values({"record.duration": 1.0, "input.period": 0.5, "record.step": 2e-5})
CHOICES: dict[str, dict[str, Any]] = {
    "paper": {},
    "laminar": {"leakage.law": "laminar"},
    "blended": {"leakage.law": "blended"},
    "ramp": {"leakage.onset": "ramp", "leakage.onset_time": 0.2, "leakage.onset_duration": 0.4},
    "smooth": {"friction.law": "smooth"},
    "scaled": {"friction.scale": 0.3},
    "external": {"leakage.external_coefficient_1": 1e-13},
    "air": {"fluid.law": "free_air"},
    "saturated": {"valve.largest_opening": 3e-5},
    "hysteresis": {"valve.hysteresis": 0.2},
    "slow": {"valve.largest_speed": 2e-3},
    "overlap": {"valve.lap": 2e-6, "valve.lap_leakage": 1e-14},
    "edges": {
        "supply_1_edge.lap": 1e-6, "return_2_edge.lap_leakage": 2e-14, "supply_2_edge.flow_gain_ratio": 0.9,
    },
    "null": {"valve.null_offset": 1e-6, "valve.null_drift": -5e-7},
    "stops": {"actuator.end_stops": "elastic", "actuator.end_stop_position": 0.02},
    "load": {"load.constant_force": 500.0, "load.random_force": 1000.0, "load.random_period": 0.1},
    "droop": {"supply.droop": "first_order"},
    "pid": {"control.law": "pid", "control.amplitude": 5e-3},
    "lugre": {"friction.law": "lugre"},
}  # fmt: skip
CHOICES["all"] = {name: value for choice in CHOICES.values() for name, value in choice.items()}
RUNS = [SHORT.with_values(values) for values in CHOICES.values()]
COEFFICIENTS = [3e-9] * len(RUNS)


@pytest.mark.parametrize("name", CHOICES)
def test_balances_close_under_every_option(name: str) -> None:
    run = SHORT.with_values(CHOICES[name] | {"record.sampling_frequency": 50e3})
    residuals = balance_residuals([run], simulate_batch([run], [3e-9]))
    assert residuals.volume[0] < 2e-6
    assert residuals.energy[0] < 2e-6


def test_no_run_depends_on_the_options_of_its_neighbours() -> None:
    together = simulate_batch(RUNS, COEFFICIENTS)
    for k, run in enumerate(RUNS):
        alone = simulate_batch([run], COEFFICIENTS[:1])
        np.testing.assert_array_equal(alone.chamber_1_pressure[0], together.chamber_1_pressure[k])
        np.testing.assert_array_equal(alone.internal_leakage_flow[0], together.internal_leakage_flow[k])


def test_every_option_changes_the_record() -> None:
    pressure = simulate_batch(RUNS, COEFFICIENTS).chamber_1_pressure
    differences = [np.abs(pressure[k] - pressure[0]).max() for k in range(1, len(RUNS))]
    assert min(differences) > 1.0


CLAMPED = {"fluid.cavitation": "clamped", "load.constant_force": -9e3, "record.step": 1e-4}
AIR_AND_LAP = CHOICES["air"] | CHOICES["overlap"]


@pytest.mark.parametrize("name", [*CHOICES, "clamped", "air and lap", "air and clamped"])
def test_both_halves_of_the_lanes_round_alike(name: str) -> None:
    """The kernel holds two copies of the equations, which the compiler must not treat differently."""
    more = {"clamped": CLAMPED, "air and lap": AIR_AND_LAP, "air and clamped": CHOICES["air"] | CLAMPED}
    values = CHOICES.get(name) or more.get(name) or {}
    runs = [
        SHORT.with_values(
            values
            | {"record.step": 1e-4, "fluid.bulk_modulus": 400e6 + 30e6 * k, "actuator.mass": 8.0 + 0.3 * k}
        )
        for k in range(HALF_WIDTH)
    ]
    coefficients = np.linspace(0.0, 5e-9, HALF_WIDTH).tolist()
    batch = simulate_batch([*runs, *runs], [*coefficients, *coefficients])
    for signal in (batch.piston_position, batch.chamber_1_pressure, batch.chamber_2_pressure):
        np.testing.assert_array_equal(signal[:HALF_WIDTH], signal[HALF_WIDTH:])
