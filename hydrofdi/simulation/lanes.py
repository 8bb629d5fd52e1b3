"""Memory layout of parallel runs in the kernel, and the options that are resolved at compile time.

A *lane* is one run. There are two halves of fixed width, so that every lane is computed by the same vector
instructions regardless of its position and the number of runs; unused lanes repeat the first run. Fields have
constant offsets in one record, so that the compiler can prove that they do not overlap.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.machine import FrictionConfig
from hydrofdi.config.request import EDGES
from hydrofdi.physics.friction import FRICTION_LAWS, LAWS

# 16 doubles fill whole vector registers of 128, 256 or 512 bits, so no lane is left over for scalar code.
HALF_WIDTH = 16
WIDTH = 2 * HALF_WIDTH
"""Number of lanes that the kernel advances together."""

SPOOL_PARAMETERS = {
    "spool_frequency": "valve.angular_frequency",
    "spool_damping_ratio": "valve.damping_ratio",
    "spool_gain": "valve.spool_gain",
    "spool_limit": "valve.position_limit",
    "spool_speed_limit": "valve.speed_limit",
    "hysteresis": "valve.hysteresis",
}
FRICTION_PARAMETERS = tuple(name for name in FrictionConfig.model_fields if name not in ("law", "scale"))
_OF_EDGES = {"lap": "lap", "leakage": "lap_leakage", "gain": "flow_gain_ratio"}

PARAMETERS = {
    "mass": "actuator.mass",
    "area": "actuator.piston_area",
    "volume": "actuator.chamber_volume",
    "area_2": "actuator.area_2",
    "volume_2": "actuator.volume_2",
    "weight": "actuator.weight",
    "stiffness": "actuator.load_stiffness",
    "stop_position": "actuator.stop_position",
    "stop_stiffness": "actuator.end_stop_stiffness",
    "hose_volume": "actuator.hose_volume",
    "hose_modulus": "actuator.hose_modulus",
    "hose_resistance": "actuator.hose_resistance",
    "hose_inertance": "actuator.hose_inertance",
    "support_stiffness": "actuator.support_stiffness",
    "support_damping": "actuator.foundation_damping",
    "rated_supply": "supply.pressure",
    "ret": "supply.return_pressure",
    "droop_resistance": "supply.droop_resistance",
    "droop_time": "supply.used_time_constant",
    "ripple": "supply.ripple_amplitude",
    "ripple_frequency": "supply.ripple_frequency",
    "return_resistance": "supply.return_resistance",
    "return_time": "supply.return_time_constant",
    "bulk_modulus": "fluid.bulk_modulus",
    "pressure_stiffening": "fluid.bulk_modulus_pressure_slope",
    "free_air": "fluid.free_air",
    "air_exponent": "fluid.polytropic_exponent",
    "atmosphere": "fluid.atmospheric_pressure",
    "temperature_rise": "fluid.temperature_rise",
    "temperature_drift": "fluid.temperature_drift",
    "bulk_modulus_slope": "fluid.bulk_modulus_slope",
    "viscosity_slope": "fluid.viscosity_slope",
    "flow_gain": "valve.flow_gain",
    "area_gradient": "valve.area_gradient",
    "lap": "valve.lap",
    "lap_leakage": "valve.lap_leakage",
    "edge_rounding": "valve.edge_rounding",
    "gain_slope": "valve.gain_slope",
    "null_offset": "valve.null_offset",
    "null_drift": "valve.null_drift",
    "external_leakage_1": "leakage.chamber_1_coefficient",
    "external_leakage_2": "leakage.chamber_2_coefficient",
    "laminar_reference": "leakage.laminar_reference",
    "blending_pressure": "leakage.blending_pressure",
    "leakage_drag": "leakage.drag",
    "scored_centre": "leakage.scored_centre",
    "scored_width": "leakage.leaking_width",
    "onset_time": "leakage.rise_start",
    "onset_duration": "leakage.rise_duration",
    "proportional_gain": "control.proportional_gain",
    "integral_gain": "control.used_integral_gain",
    "derivative_gain": "control.used_derivative_gain",
    "sample_time": "control.sample_time",
    "voltage_limit": "control.voltage_limit",
    "reading_gain": "position_sensor.gain",
    "lowest_reading": "position_sensor.lower_end",
    "highest_reading": "position_sensor.upper_end",
    "reading_resolution": "position_sensor.resolution",
    **SPOOL_PARAMETERS,
    **{
        f"{edge.removesuffix('_edge')}_{name}": f"{edge}.{field}"
        for edge in EDGES
        for name, field in _OF_EDGES.items()
    },
    **{name: f"friction.applied.{name}" for name in FRICTION_PARAMETERS},
}
"""Lane field → the parameter that fills it, in SI."""

LEAKAGE = "internal_leakage"
"""Lane field of K_i, which is calibrated and therefore not one of the parameters."""

LINES = ("line_pressure_1", "line_flow_1", "line_pressure_2", "line_flow_2")
"""States of the hoses."""

HIDDEN = {"return_pressure": "return_line", "support": "foundation", **dict.fromkeys(LINES, "hoses")}
"""Integrated states that results do not store, and the options that they need: P_r, x_b and the hoses."""

OPTIONAL = {"supply": "moving_supply", "bristle": "bristles", **HIDDEN}
"""States that are constant without an option: P_s, z and the hidden ones."""

STATES = ("position", "velocity", "pressure_1", "pressure_2", *OPTIONAL)
"""Integrated states of a lane: x_p, v_p, P_1, P_2, and the optional ones."""

_LOOP = ("spool_position", "spool_velocity", "voltage", "acting_voltage", "error", "integral")
"""State of spool and controller of a lane in closed loop."""

_STEP = ("spool_1", "spool_2", "spool_3", "spool_4", "load")
"""Spool position x_v at the four Runge-Kutta stages of the current step, and the load force."""

SAMPLED = (*STATES, "voltage", "spool_position")
"""Rows of the samples; those from P_s on are filled only if an option requires them."""

N_PAPER_SAMPLED = 4
"""Number of rows of the paper's model."""

_HALF = np.dtype([(name, "f8", (HALF_WIDTH,)) for name in (*PARAMETERS, LEAKAGE, *STATES, *_LOOP, *_STEP)])
LANES = np.dtype([("left", _HALF), ("right", _HALF)])
"""Record of all lanes."""

SINGLE = np.dtype([(name, "f8", (1,)) for name in (*PARAMETERS, LEAKAGE)])
"""Record of the parameters of one run, with a width of one lane."""

_values_of = attrgetter(*PARAMETERS.values())

_SPOOL_FIELDS = (
    *SPOOL_PARAMETERS, "spool_position", "spool_velocity", "voltage", "acting_voltage",
    "spool_1", "spool_2", "spool_3", "spool_4",
)  # fmt: skip
SPOOLS = np.dtype([(name, "f8", (WIDTH,)) for name in _SPOOL_FIELDS])
"""Record of the spools of several drives."""


def pack_lanes(parameters: Sequence[RunParameters], leakage_coefficients: Sequence[float]) -> NDArray[Any]:
    """Make lanes in the initial state: at rest, centred, with the chambers at their ``start_pressures``.

    Parameters
    ----------
    parameters : sequence of RunParameters, length 1 … WIDTH
        One run per lane.
    leakage_coefficients : sequence of float, of the same length
        K_i [m^3.5/kg^0.5].

    Returns
    -------
    ndarray of LANES, shape (1,)
    """
    lanes = np.zeros(1, LANES)
    values = pack_singles(parameters, leakage_coefficients).view(np.float64).reshape(len(parameters), -1)
    # Run of each lane; unused lanes compute run 0 again, with valid numbers.
    of_lane = np.arange(WIDTH) * (np.arange(WIDTH) < len(values))
    # Fields of a half are contiguous rows that start with the parameters, so one assignment fills them all.
    halves = lanes.view(np.float64).reshape(2, -1, HALF_WIDTH)
    halves[:, : values.shape[1]] = values[of_lane].reshape(2, HALF_WIDTH, -1).transpose(0, 2, 1)
    starts = np.array([(*run.start_pressures, run.start_support) for run in parameters])[of_lane].T
    for half, start in zip(("left", "right"), np.split(starts, 2, axis=1), strict=True):
        state = lanes[half]
        # P_s and P_r start at no flow, hoses at the pressures of their chambers.
        state["supply"], state["return_pressure"] = state["rated_supply"], state["ret"]
        state["pressure_1"] = state["line_pressure_1"] = start[0]
        state["pressure_2"] = state["line_pressure_2"] = start[1]
        state["support"] = start[2]
    return lanes


def pack_singles(parameters: Sequence[RunParameters], leakage_coefficients: Sequence[float]) -> NDArray[Any]:
    """Parameters of runs by name, in SI: ndarray of SINGLE, shape (n_run,)."""
    values = np.column_stack([[_values_of(run) for run in parameters], leakage_coefficients])
    return np.ascontiguousarray(values, dtype=np.float64).view(SINGLE)[:, 0]


OPTIONS: dict[str, Callable[[RunParameters], bool]] = {
    "laminar_leakage": lambda run: run.leakage.law == "laminar",
    "blended_leakage": lambda run: run.leakage.law == "blended",
    "dragged_leakage": lambda run: run.leakage.drag > 0.0,
    "scored_bore": lambda run: run.leakage.scored_width is not None,
    "ramped_leakage": lambda run: run.leakage.onset != "constant",
    "unequal_chambers": lambda run: run.actuator.has_unequal_chambers,
    "inclined": lambda run: run.actuator.inclination != 0.0,
    "bristles": lambda run: FRICTION_LAWS[run.friction.law].has_bristles,
    "uneven_friction": lambda run: run.friction.pressure_slope != 0.0 or run.friction.position_share != 0.0,
    "warm_oil": lambda run: run.fluid.temperature_rise != 0.0 or run.fluid.temperature_drift != 0.0,
    "stiffening": lambda run: run.fluid.bulk_modulus_pressure_slope > 0.0,
    "free_air": lambda run: run.fluid.law == "free_air",
    "limited_spool": lambda run: run.valve.is_limited,
    "hysteresis": lambda run: run.valve.hysteresis > 0.0,
    # Laps, clearances, and wear of single edges.
    "lapped_valve": lambda run: (
        run.valve.lap != 0.0
        or run.valve.lap_leakage != 0.0
        or run.valve.is_worn
        or not all(getattr(run, edge).is_default for edge in EDGES)
    ),
    "worn_edges": lambda run: run.valve.is_worn,
    "shifted_null": lambda run: run.valve.null_offset != 0.0 or run.valve.null_drift != 0.0,
    "end_stops": lambda run: run.actuator.end_stops == "elastic",
    "foundation": lambda run: run.actuator.foundation_stiffness is not None,
    "hoses": lambda run: run.actuator.hose_volume > 0.0,
    "load_force": lambda run: run.load.constant_force != 0.0 or run.load.random_force != 0.0,
    # A ripple makes P_s a state as well.
    "moving_supply": lambda run: run.supply.droop == "first_order" or run.supply.ripple > 0.0,
    "supply_ripple": lambda run: run.supply.ripple > 0.0,
    "return_line": lambda run: run.supply.return_resistance > 0.0,
    "closed_loop": lambda run: run.control.is_closed,
    "measured_feedback": lambda run: run.control.is_measured,
}
"""Option of the model beyond that of the paper → whether a run needs it."""

if TYPE_CHECKING:
    _Options = Any
else:
    _Options = namedtuple(
        "_Options", (*OPTIONS, "friction_law"), defaults=(*[False] * len(OPTIONS), LAWS[0].name)
    )


class ModelOptions(_Options):  # type: ignore[misc]
    """The `OPTIONS` of a run and its friction law; each combination has machine code of its own."""

    __slots__ = ()

    @property
    def samples_more(self) -> bool:
        """Whether a lane has more samples than the paper's model."""
        return any((self.closed_loop, *(getattr(self, option) for option in OPTIONAL.values())))

    @classmethod
    def of(cls, run: RunParameters) -> ModelOptions:
        """Options of a run."""
        return cls(*(is_needed(run) for is_needed in OPTIONS.values()), run.friction.law)


Key = TypeVar("Key", bound=Hashable)


def positions_by(keys: Iterable[Key]) -> dict[Key, list[int]]:
    """Distinct keys of runs, such as `ModelOptions`, each with the positions of its runs."""
    positions: dict[Key, list[int]] = {}
    for position, key in enumerate(keys):
        positions.setdefault(key, []).append(position)
    return positions


def indices(positions: Mapping[Any, list[int]], n_run: int) -> NDArray[np.intp]:
    """Of each run, the index of its key among those of `positions_by`."""
    index_of_run = np.empty(n_run, dtype=np.intp)
    for index, members in enumerate(positions.values()):
        index_of_run[members] = index
    return index_of_run


def lane_groups(keys: Iterable[Key]) -> Iterator[tuple[Key, list[int]]]:
    """Keys of runs, each with the positions of at most WIDTH of its runs."""
    for key, members in positions_by(keys).items():
        for first in range(0, len(members), WIDTH):
            yield key, members[first : first + WIDTH]
