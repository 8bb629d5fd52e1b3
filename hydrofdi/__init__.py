"""hydrofdi: detect internal leakage in hydraulic actuators. Simulate, study what can be detected, monitor.

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
    from hydrofdi.api.check import calibrate, check
    from hydrofdi.api.detectors.detecting import detect
    from hydrofdi.api.detectors.detector import Detector
    from hydrofdi.api.detectors.training import train
    from hydrofdi.api.evaluating import evaluate
    from hydrofdi.api.evaluation import Evaluation
    from hydrofdi.api.exporting import Exported, export
    from hydrofdi.api.folders import collect, rerun, status, verify, why
    from hydrofdi.api.inspecting import Inspection, inspect
    from hydrofdi.api.listing import describe_indicator, list_indicators
    from hydrofdi.api.measuring import measure
    from hydrofdi.api.plan import plan
    from hydrofdi.api.replaying import replay
    from hydrofdi.api.results import Results, results
    from hydrofdi.api.run import Run, simulate
    from hydrofdi.api.schemas import schema
    from hydrofdi.api.sweep import sweep
    from hydrofdi.config import load_experiment
    from hydrofdi.errors import HydrofdiError
    from hydrofdi.report.table import Table

__version__ = "0.1.0"

_HOMES = {
    "Detector": "hydrofdi.api.detectors.detector",
    "Evaluation": "hydrofdi.api.evaluation",
    "Exported": "hydrofdi.api.exporting",
    "HydrofdiError": "hydrofdi.errors",
    "Inspection": "hydrofdi.api.inspecting",
    "Results": "hydrofdi.api.results",
    "Run": "hydrofdi.api.run",
    "Table": "hydrofdi.report.table",
    "calibrate": "hydrofdi.api.check",
    "check": "hydrofdi.api.check",
    "collect": "hydrofdi.api.folders",
    "describe_indicator": "hydrofdi.api.listing",
    "detect": "hydrofdi.api.detectors.detecting",
    "evaluate": "hydrofdi.api.evaluating",
    "export": "hydrofdi.api.exporting",
    "inspect": "hydrofdi.api.inspecting",
    "list_indicators": "hydrofdi.api.listing",
    "load_experiment": "hydrofdi.config",
    "measure": "hydrofdi.api.measuring",
    "plan": "hydrofdi.api.plan",
    "replay": "hydrofdi.api.replaying",
    "rerun": "hydrofdi.api.folders",
    "results": "hydrofdi.api.results",
    "schema": "hydrofdi.api.schemas",
    "simulate": "hydrofdi.api.run",
    "status": "hydrofdi.api.folders",
    "sweep": "hydrofdi.api.sweep",
    "train": "hydrofdi.api.detectors.training",
    "verify": "hydrofdi.api.folders",
    "why": "hydrofdi.api.folders",
}
"""Name → module that it is loaded from when it is first used."""

__all__ = [
    "Detector",
    "Evaluation",
    "Exported",
    "HydrofdiError",
    "Inspection",
    "Results",
    "Run",
    "Table",
    "__version__",
    "calibrate",
    "check",
    "collect",
    "describe_indicator",
    "detect",
    "evaluate",
    "export",
    "inspect",
    "list_indicators",
    "load_experiment",
    "measure",
    "plan",
    "replay",
    "rerun",
    "results",
    "schema",
    "simulate",
    "status",
    "sweep",
    "train",
    "verify",
    "why",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'hydrofdi' has no attribute {name!r}")
    found = getattr(import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
