"""How far an actuator may be from its data sheet: standard deviations that hold an estimate together."""

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
    """A nominal actuator and the standard deviations of what it is; zero says that it is known."""

    bulk_modulus_deviation: Share = 0.3
    """Standard deviation of 1/β over its nominal value [-]."""

    chamber_volume_deviation: Share = 0.02
    """Standard deviation of the chamber volumes over their nominal value [-]. It goes into the deviation of β
    in full: pressures tell β/V. That is too wide where flow gain and lap, which are estimated, take up the
    error of the volume instead, as in balances under a square wave in open loop."""

    flow_gain_deviation: Share = 0.025
    """Standard deviation of the flow through the open valve over its nominal value [-]."""

    supply_deviation: Share | None = None
    """Standard deviation of the supply pressure relative to its value [-]; by default 0.002 if measured, 0.03
    if nominal, and 0.001 if from the sum of pressures, or 0.01 with one of them."""

    offset_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 0.5e-6
    """Standard deviation of the spool position at which the valve is closed, about zero [m]."""

    lap_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 0.6e-6
    """Standard deviation of the lap x_0 of the valve, about zero [m]."""

    clearance_deviation: Annotated[float, SI("m^3/(s*Pa)", least=0, most=1.0)] = 1e-14
    """Standard deviation of the conductance of the clearance over each edge of the valve [m³/(s·Pa)]."""

    pressure_bias: Annotated[float, SI("Pa", least=0, most=2e8)] = 25e3
    """Standard deviation of the constant error of each chamber pressure sensor [Pa]."""

    def bulk_modulus_error(self, modulus: Array, error: Array) -> Array:
        """Standard deviation of β [Pa] from that with chambers of nominal volume."""
        return np.asarray(np.hypot(error, self.chamber_volume_deviation * modulus))

    def prior_deviations(self, records: RecordBatch, n_pressure: int) -> dict[str, float]:
        """Unknown → its standard deviation beforehand; that of K_i is infinite, what is known is left out."""
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
