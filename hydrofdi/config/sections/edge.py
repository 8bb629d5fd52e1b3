"""The sections of the four metering edges of the valve: how each differs from what they have in common."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from hydrofdi.config.sections.valve import ValveConfig
from hydrofdi.settings.quantities import SI, Section


class EdgeConfig(Section):
    """Metering edge of the valve; by default like the others."""

    lap: Annotated[float, SI("m", usual=("10 nm", "1 mm"))] = 0.0
    """Additional lap of this edge beyond ``valve.lap`` [m]; negative if it opens earlier."""

    lap_leakage: Annotated[
        float, SI("m^3/(s*Pa)", least=0, usual=("1e-18 m^3/(s*Pa)", "1e-8 m^3/(s*Pa)"))
    ] = 0.0
    """Additional conductance of its clearance beyond ``valve.lap_leakage`` [m³/(s·Pa)]."""

    flow_gain_ratio: Annotated[float, SI("1", above=0, usual=("0.1", "10"))] = 1.0
    """Its flow gain over ``valve.flow_gain`` [-]."""


class Edge(NamedTuple):
    """What one edge has in all: x_0 [m], c_lap [m³/(s·Pa)] and K_v [m^1.5/kg^0.5]."""

    lap: float
    lap_leakage: float
    flow_gain: float

    @classmethod
    def of(cls, valve: ValveConfig, own: EdgeConfig) -> Edge:
        """What the edges have in common, and what this one has of its own."""
        return cls(
            valve.lap + own.lap, valve.lap_leakage + own.lap_leakage, valve.flow_gain * own.flow_gain_ratio
        )


class Edges(NamedTuple):
    """The edges between supply, return and the chambers."""

    supply_1: Edge
    return_1: Edge
    supply_2: Edge
    return_2: Edge

    @property
    def largest_underlap(self) -> float:
        """How far an edge stands open at the null, at most [m]."""
        return max(0.0, *(-edge.lap for edge in self))

    @property
    def clearances(self) -> tuple[float, float]:
        """Conductance of the clearances of each chamber [m³/(s·Pa)]."""
        return (
            self.supply_1.lap_leakage + self.return_1.lap_leakage,
            self.supply_2.lap_leakage + self.return_2.lap_leakage,
        )
