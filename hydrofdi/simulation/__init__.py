"""Simulation: from resolved runs to sampled signals."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrofdi.simulation.batch import simulate_batch
    from hydrofdi.simulation.calibration import Calibration, solve_leakage_coefficients
    from hydrofdi.simulation.identity import (
        identities_of_analyses,
        record_identities,
        record_identity,
        run_identities,
        run_identity,
    )
    from hydrofdi.simulation.trajectory import Outcome, Trajectory

_HOMES = {
    "Calibration": "hydrofdi.simulation.calibration",
    "Outcome": "hydrofdi.simulation.trajectory",
    "Trajectory": "hydrofdi.simulation.trajectory",
    "identities_of_analyses": "hydrofdi.simulation.identity",
    "record_identities": "hydrofdi.simulation.identity",
    "record_identity": "hydrofdi.simulation.identity",
    "run_identities": "hydrofdi.simulation.identity",
    "run_identity": "hydrofdi.simulation.identity",
    "simulate_batch": "hydrofdi.simulation.batch",
    "solve_leakage_coefficients": "hydrofdi.simulation.calibration",
}
"""Name → module, which is loaded when the name is first used, so that commands load only what they need."""

__all__ = [
    "Calibration",
    "Outcome",
    "Trajectory",
    "identities_of_analyses",
    "record_identities",
    "record_identity",
    "run_identities",
    "run_identity",
    "simulate_batch",
    "solve_leakage_coefficients",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
