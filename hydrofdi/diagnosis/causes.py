"""What a fault may change, and by which unknowns of the volume balance it is seen."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hydrofdi.indicators.estimation.chamber_balance import UNKNOWNS

N_PLACE = 6
"""Number of places on the stroke at which K_i is an unknown of its own."""

LEAKS = tuple(f"internal_coefficient_{place}" for place in range(N_PLACE))

N_FINE = 18
"""Number of places on the stroke at which a score may leak."""

SCORES = tuple(f"leak_{place}" for place in range(N_FINE))

GAPS = tuple(f"gap_{place}" for place in range(N_FINE))

_MORE = ("laminar", "external_1", "external_2", "gain_1", "gain_2", "lag", "position_lag")

NAMES = (*LEAKS, *UNKNOWNS[1:], *_MORE)
"""Unknowns: K_i along the stroke, those of `chamber_balance`, conductances of a laminar seal leak and of
leaks of each chamber to the outside, relative gain errors of the pressures, and how much spool and position
are behind [s]."""

CAUSES = (*NAMES, "position_gain", "bow", "feed_1", "feed_2", *SCORES, *GAPS)
"""The unknowns, and what else a fault may change and is seen through them: relative gain error of the
position (as an unknown it would explain all motion away), that of the valve at its largest opening if it
grows evenly from none, conductances of the clearance of each supply edge, and holes and gaps along the
stroke, at more places than K_i is an unknown of its own."""

N_CHANGE = len(NAMES) + 2
"""Number of the causes that are no detail of a listed fault."""

PLACE = {name: place for place, name in enumerate(CAUSES)}

EDGES = {"supply 1": (1, 1), "return 1": (1, -1), "supply 2": (-1, -1), "return 2": (-1, 1)}
"""Metering edge → sign of its chamber, and of the spool position that opens it."""

OF_EDGES = ("lap", "offset", "lap_by_feeding", "lap_by_chamber")

CONTRASTS = np.array([(1, side, chamber * side, chamber) for chamber, side in EDGES.values()], dtype=float)
"""Lap of each edge from `OF_EDGES`."""

UNLISTED = (
    "lap", "clearance", "supply_resistance", "gain_by_direction", "gain_by_feeding", "gain_by_chamber", "lag",
    "position_lag", "bow", "viscous", "stiffness",
)  # fmt: skip
"""Causes of which one may change alone in a fault without a hypothesis."""

SENSORS: Mapping[str, Mapping[str, float]] = {
    "supply pressure": {"supply": 2e-3},
    "return pressure": {"return_pressure": 2e4},
    "load force": {"coulomb": 10.0, "force": 50.0},
    "a second gauge on chamber 1": {"bias_1": 1e4, "gain_1": 1e-3},
    "a second gauge on chamber 2": {"bias_2": 1e4, "gain_2": 1e-3},
    "a second position sensor": {"position_gain": 1e-3},
    "spool position": {"flow_gain": 5e-3},
    "an oil sample (air, bulk modulus)": {"free_air": 1e-3},
}
"""What can be measured in addition → quantities that it states, and their errors in SI."""
