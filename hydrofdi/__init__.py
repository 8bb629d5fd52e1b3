"""hydrofdi: wavelet-based diagnosis of internal leakage in hydraulic actuators.

The public names below are loaded when they are first used, so that importing the package costs nothing.

>>> import hydrofdi
>>> run = hydrofdi.simulate(bulk_modulus="689 MPa", internal_flow="0.2 L/min", duration="4 s")
>>> run.status
'ok'
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrofdi.api.detector import Detector
    from hydrofdi.api.exporting import Exported, export
    from hydrofdi.api.measuring import measure
    from hydrofdi.api.results import Results, results, sweep
    from hydrofdi.api.run import Run, simulate
    from hydrofdi.api.table import Table
    from hydrofdi.config import expand_runs, load_experiment
    from hydrofdi.errors import HydrofdiError
    from hydrofdi.pipeline import plan_sweep, run_sweep
    from hydrofdi.report import summarize_table
    from hydrofdi.simulation import simulate_batch, solve_leakage_coefficients
    from hydrofdi.store import read_experiment
    from hydrofdi.transforms.change import percentage_change
    from hydrofdi.transforms.wavelet import detail_rms

__version__ = "0.1.0"

_HOMES = {
    "HydrofdiError": "hydrofdi.errors",
    "Run": "hydrofdi.api.run",
    "Table": "hydrofdi.api.table",
    "simulate": "hydrofdi.api.run",
    "Detector": "hydrofdi.api.detector",
    "Exported": "hydrofdi.api.exporting",
    "export": "hydrofdi.api.exporting",
    "measure": "hydrofdi.api.measuring",
    "Results": "hydrofdi.api.results",
    "results": "hydrofdi.api.results",
    "sweep": "hydrofdi.api.results",
    "load_experiment": "hydrofdi.config",
    "expand_runs": "hydrofdi.config",
    "simulate_batch": "hydrofdi.simulation",
    "solve_leakage_coefficients": "hydrofdi.simulation",
    "detail_rms": "hydrofdi.transforms.wavelet",
    "percentage_change": "hydrofdi.transforms.change",
    "plan_sweep": "hydrofdi.pipeline",
    "run_sweep": "hydrofdi.pipeline",
    "read_experiment": "hydrofdi.store",
    "summarize_table": "hydrofdi.report",
}

__all__ = [
    "Detector",
    "Exported",
    "HydrofdiError",
    "Results",
    "Run",
    "Table",
    "__version__",
    "detail_rms",
    "expand_runs",
    "export",
    "load_experiment",
    "measure",
    "percentage_change",
    "plan_sweep",
    "read_experiment",
    "results",
    "run_sweep",
    "simulate",
    "simulate_batch",
    "solve_leakage_coefficients",
    "summarize_table",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'hydrofdi' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
