"""Records of the nominal machine in closed loop: healthy days, and days with a fault."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.records import RecordBatch
from tests.machines import SHEET, TINY, sections_of

N_HEALTHY = 8

_MOTION = sections_of(SHEET | {
    "input.shape": "steps", "input.period": "1 s", "record.duration": "16 s", "control.amplitude": "20 mm",
    "load.random_force": "1 kN", "load.random_period": "0.5 s", "fluid.free_air": 0.005,
    "pressure_1_sensor.noise": "5 kPa", "pressure_2_sensor.noise": "5 kPa", "position_sensor.noise": "10 um",
})  # fmt: skip

_NORMAL = {
    "leakage.internal_coefficient": 0.0, "leakage.law": "orifice", "leakage.external_coefficient_1": 0.0,
    "valve.null_offset": TINY, "valve.hysteresis": TINY, "supply_1_edge.lap": 0.0, "supply.pressure": 17.2e6,
    "supply.return_pressure": 4e5, "fluid.bulk_modulus": 551e6, "pressure_1_sensor.bias": 0.0,
    "pressure_2_sensor.gain_error": 0.0, "voltage_sensor.gain_error": 0.0, "friction.scale": 1.0,
}  # fmt: skip

Days = Callable[[Sequence[Mapping[str, Any]]], RecordBatch]


@pytest.fixture(scope="session")
def days() -> Days:
    """Records of days on which some parameters differ; each has its own motion, load, noise and warmth."""

    def made(changes: Sequence[Mapping[str, Any]], first: int = 1) -> RecordBatch:
        rows = []
        for number, change in enumerate(changes, start=first):
            draw = np.random.default_rng(number)
            own = {f"{part}.seed": number for part in ("input", "load", "measurement")}
            rows.append(_NORMAL | own | {"fluid.temperature_rise": draw.uniform(-8.0, 8.0)} | dict(change))
        swept = {"zip": {key: [row[key] for row in rows] for key in rows[0]}}
        source = SimulatedRecords(
            load_experiment(_MOTION | {"name": "days", "sweep": swept}), "days", only=range(len(rows))
        )
        batches = [*source.batches()]
        rows_of = {each: batch.rows([row]) for batch in batches for row, each in enumerate(batch.record_ids)}
        ordered = [rows_of[each] for each in source.record_ids[: len(rows)]]
        channels = {name: np.concatenate([each[name] for each in ordered]) for name in ordered[0].channels}
        ids = tuple(f"day {first + row}" for row in range(len(rows)))
        return RecordBatch(channels, ordered[0].sampling_frequency, ids)

    return made


@pytest.fixture(scope="session")
def healthy(days: Days) -> RecordBatch:
    """Healthy days."""
    return days([{}] * N_HEALTHY)
