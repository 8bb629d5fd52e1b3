"""Prior uncertainty of an actuator: standard deviations about its data sheet."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI

Share = Annotated[float, SI("1", least=0, most=1e3)]

_SUPPLY = {"measured": 2e-3, "sum": 1e-3, "nominal": 0.03}
_SUPPLY_OF_ONE_PRESSURE = {"measured": 2e-3, "sum": 0.01, "nominal": 0.03}


class UncertainActuator(NominalActuator):
    """A nominal actuator and prior standard deviations of its parameters; zero means exactly known."""

    bulk_modulus_deviation: Share = 0.3
    """Relative standard deviation of 1/β [-]."""

    chamber_volume_deviation: Share = 0.02
    """Relative standard deviation of the chamber volumes [-]. It is added in full to the deviation of β,
    because pressures determine only β/V. This is too wide if the estimated flow gain and lap absorb the
    volume error instead, as in balances under a square wave in open loop."""

    flow_gain_deviation: Share = 0.025
    """Relative standard deviation of the flow through the open valve [-]."""

    supply_deviation: Share | None = None
    """Relative standard deviation of the supply pressure [-]; by default 0.002 if measured, 0.03 if nominal,
    0.001 if from the sum of pressures, and 0.01 if from one pressure."""

    offset_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 0.5e-6
    """Standard deviation of the spool position at which the valve is closed, about zero [m]."""

    lap_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 0.6e-6
    """Standard deviation of the lap x_0 of the valve, about zero [m]."""

    clearance_deviation: Annotated[float, SI("m^3/(s*Pa)", least=0, most=1.0)] = 1e-14
    """Standard deviation of the conductance of the clearance at each valve edge [m³/(s·Pa)]."""

    pressure_bias: Annotated[float, SI("Pa", least=0, most=2e8)] = 25e3
    """Standard deviation of the constant error of each chamber pressure sensor [Pa]."""

    def bulk_modulus_error(self, modulus: Array, error: Array) -> Array:
        """Standard deviation of β [Pa], from the one that assumes nominal chamber volumes."""
        return np.asarray(np.hypot(error, self.chamber_volume_deviation * modulus))

    def prior_deviations(self, records: RecordBatch, n_pressure: int) -> dict[str, float]:
        """Unknown → prior standard deviation; infinite for K_i. Known parameters are omitted."""
        usual = (_SUPPLY if n_pressure == 2 else _SUPPLY_OF_ONE_PRESSURE)[self.supply_known_by(records)]
        deviations = {
            "internal_coefficient": math.inf,
            "compressibility": self.bulk_modulus_deviation / self.bulk_modulus,
            "flow_gain": self.flow_gain_deviation,
            "supply": usual if self.supply_deviation is None else self.supply_deviation,
            "offset": self.offset_deviation,
            "lap": self.lap_deviation,
            "clearance": self.clearance_deviation,
            "bias_1": self.pressure_bias,
            "bias_2": self.pressure_bias if n_pressure == 2 else 0.0,
        }
        return {name: deviation for name, deviation in deviations.items() if deviation > 0.0}
