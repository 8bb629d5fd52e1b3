"""From resolved runs to sampled signals."""

from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.calibration import Calibration, solve_leakage_coefficients
from hydrofdi.simulation.identity import run_identities, run_identity
from hydrofdi.simulation.trajectory import Outcome, Trajectory

__all__ = [
    "Calibration",
    "Outcome",
    "Trajectory",
    "run_identities",
    "run_identity",
    "simulate_batch",
    "solve_leakage_coefficients",
]
