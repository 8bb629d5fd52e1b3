"""hydrofdi: wavelet-based diagnosis of internal leakage in hydraulic actuators.

The public names below are loaded when they are first used, so that importing the package costs nothing.

>>> import hydrofdi
>>> experiment = hydrofdi.load_experiment(settings=["fluid.bulk_modulus=689 MPa"])
>>> experiment.fluid.bulk_modulus
689000000.0
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "HydrofdiError": "hydrofdi.errors",
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

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'hydrofdi' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
