"""Runs side by side: the memory that the kernel works on.

A *lane* is one run. Lanes lie in two halves of fixed width, so that every lane is computed by the same vector
instructions wherever it stands and however many runs there are; unused lanes repeat the first run. Fields of
one record have constant distances, which lets the compiler prove that they do not overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters

HALF_WIDTH = 16
WIDTH = 2 * HALF_WIDTH
"""Number of lanes that the kernel advances together."""

PARAMETERS = {
    "mass": "actuator.mass",
    "area": "actuator.piston_area",
    "volume": "actuator.chamber_volume",
    "stiffness": "actuator.load_stiffness",
    "supply": "supply.pressure",
    "ret": "supply.return_pressure",
    "bulk_modulus": "fluid.bulk_modulus",
    "flow_gain": "valve.flow_gain",
    "area_gradient": "valve.area_gradient",
    "coulomb": "friction.dry_coulomb",
    "breakaway": "friction.dry_breakaway",
    "viscous": "friction.viscous",
    "transition": "friction.transition",
    "velocity_threshold": "friction.velocity_threshold",
    "internal_leakage": "leakage.internal_coefficient",
    "external_leakage_1": "leakage.chamber_1_coefficient",
    "external_leakage_2": "leakage.chamber_2_coefficient",
    "laminar_reference": "leakage.laminar_reference",
    "blending_pressure": "leakage.blending_pressure",
    "onset_time": "leakage.rise_start",
    "onset_duration": "leakage.rise_duration",
    "onset_duty": "leakage.onset_duty",
}
"""Lane field → the parameter that fills it, in SI."""

STATES = ("position", "velocity", "pressure_1", "pressure_2")
"""Integrated states of a lane: x_p, v_p, P_1, P_2."""

SPOOL_STAGES = ("spool_1", "spool_2", "spool_3", "spool_4")
"""Spool position x_v at the four Runge-Kutta stages of the current step."""

_HALF = np.dtype([(name, "f8", (HALF_WIDTH,)) for name in (*PARAMETERS, *STATES, *SPOOL_STAGES)])
LANES = np.dtype([("left", _HALF), ("right", _HALF)])
"""Record of all lanes."""


SPOOL_WIDTH = 16
"""Number of spools that are advanced together."""

_SPOOL_FIELDS = (
    "position", "velocity", "frequency", "damping_ratio", "gain",
    "voltage", "stage_1", "stage_2", "stage_3", "stage_4",
)  # fmt: skip
SPOOLS = np.dtype([(name, "f8", (SPOOL_WIDTH,)) for name in _SPOOL_FIELDS])
"""Record of the spools of several drives."""


def pack_lanes(parameters: Sequence[RunParameters], leakage_coefficients: Sequence[float]) -> NDArray[Any]:
    """Lanes at the initial state: at rest, centred, both chambers at the mean of supply and return pressure.

    Parameters
    ----------
    parameters : sequence of RunParameters, length 1 … WIDTH
        One per lane.
    leakage_coefficients : sequence of float, of the same length
        K_i [m^3.5/kg^0.5].

    Returns
    -------
    ndarray of LANES, shape (1,)
    """
    lanes = np.zeros(1, LANES)
    values = parameter_matrix(parameters, leakage_coefficients)
    for column, field in enumerate(PARAMETERS):
        _fill(lanes, field, values[:, column])
    for half in ("left", "right"):
        state = lanes[half]
        state["pressure_1"] = state["pressure_2"] = 0.5 * (state["supply"] + state["ret"])
    return lanes


def parameter_matrix(
    parameters: Sequence[RunParameters], leakage_coefficients: Sequence[float]
) -> NDArray[np.float64]:
    """Parameters of runs in the order of ``PARAMETERS``, shape (n_run, n_parameter), in SI."""
    matrix = np.empty((len(parameters), len(PARAMETERS)))
    for column, (field, name) in enumerate(PARAMETERS.items()):
        if field == "internal_leakage":
            matrix[:, column] = leakage_coefficients
        else:
            matrix[:, column] = [run.value(name) for run in parameters]
    return matrix


def _fill(lanes: NDArray[Any], field: str, values: NDArray[np.float64]) -> None:
    padded = np.full(WIDTH, values[0])
    padded[: len(values)] = values
    lanes["left"][field] = padded[:HALF_WIDTH]
    lanes["right"][field] = padded[HALF_WIDTH:]
