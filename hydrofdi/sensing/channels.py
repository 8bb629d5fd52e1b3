"""Signals that have a sensor, and their random generators."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.sensor import SensorConfig
from hydrofdi.sensing.dynamics import Lag, butterworth_lags, first_order_lag, second_order_lag


@dataclass(frozen=True)
class Channel:
    """A signal that has a sensor: its name in a trajectory, and the section of its sensor."""

    signal: str
    section: str

    def sensor(self, run: RunParameters) -> SensorConfig:
        """Sensor configuration of this channel in a run."""
        sensor: SensorConfig = getattr(run, self.section)
        return sensor

    def lags(self, run: RunParameters) -> tuple[Lag, ...]:
        """Lags that the signal passes before sampling; empty if there are none."""
        sensor, shared, turn = self.sensor(run), run.measurement, 2.0 * math.pi * run.record.step
        lags: tuple[Lag, ...] = ()
        if sensor.bandwidth is not None and sensor.order == "first":
            lags = (first_order_lag(turn * sensor.bandwidth),)
        elif sensor.bandwidth is not None:
            lags = (second_order_lag(turn * sensor.bandwidth, sensor.damping_ratio),)
        if shared.anti_alias is not None:
            lags += butterworth_lags(turn * shared.anti_alias, shared.anti_alias_order)
        return lags


CHANNELS = (
    Channel("chamber_1_pressure", "pressure_1_sensor"),
    Channel("chamber_2_pressure", "pressure_2_sensor"),
    Channel("valve_supply_pressure", "supply_sensor"),
    Channel("piston_position", "position_sensor"),
    Channel("piston_velocity", "velocity_sensor"),
    Channel("spool_position", "spool_sensor"),
    Channel("input_voltage", "voltage_sensor"),
)

CLOCK = "clock"
"""Random source of the sampling jitter; all channels share it."""


def random_generator(run: RunParameters, source: str) -> np.random.Generator:
    """Random generator of one source of error in one record.

    The seed is the SHA-256 of the replicate (``measurement.seed``), the source, and with
    ``measurement.pairing: independent`` all parameters that determine the record. So draws do not depend on
    other records, on order, batch or worker, or on the analysis. The generator is NumPy's PCG64; draws are
    bit-identical within one version of NumPy.

    Parameters
    ----------
    run : RunParameters
    source : str
        Section of a sensor, or `CLOCK`.
    """
    record = run.text() if run.measurement.pairing == "independent" else "common"
    text = f"{run.measurement.seed}\n{source}\n{record}"
    seed = int.from_bytes(hashlib.sha256(text.encode()).digest(), "big")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
