"""hydrofdi: detect internal leakage in hydraulic actuators. Simulate, study what can be detected, monitor.

The public names below are loaded when they are first used, so that importing the package costs nothing.

>>> import hydrofdi
>>> run = hydrofdi.simulate(bulk_modulus="689 MPa", internal_flow="0.2 L/min", duration="4 s")
>>> run.status
'ok'
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from hydrofdi.version import __version__

if TYPE_CHECKING:
    from hydrofdi.api.check import calibrate, check
    from hydrofdi.api.detectors.detector import Detector, detect
    from hydrofdi.api.detectors.training import train
    from hydrofdi.api.evaluation import Evaluation, evaluate
    from hydrofdi.api.exporting import Exported, export
    from hydrofdi.api.folders import rerun, status, verify, why
    from hydrofdi.api.inspecting import Inspection, inspect
    from hydrofdi.api.measuring import indicators, measure
    from hydrofdi.api.plan import plan
    from hydrofdi.api.replaying import replay
    from hydrofdi.api.results import Results, load, report
    from hydrofdi.api.run import Run, simulate
    from hydrofdi.api.sweep import collect, sweep
    from hydrofdi.config import load_experiment
    from hydrofdi.errors import HydrofdiError
    from hydrofdi.report.table import Table
    from hydrofdi.settings.ready import schema

_HOMES = {
    name: f"hydrofdi.{module}"
    for module, names in {
        "api.check": "calibrate check",
        "api.detectors.detector": "Detector detect",
        "api.detectors.training": "train",
        "api.evaluation": "Evaluation evaluate",
        "api.exporting": "Exported export",
        "api.folders": "rerun status verify why",
        "api.inspecting": "Inspection inspect",
        "api.measuring": "indicators measure",
        "api.plan": "plan",
        "api.replaying": "replay",
        "api.results": "Results load report",
        "api.run": "Run simulate",
        "api.sweep": "collect sweep",
        "config": "load_experiment",
        "errors": "HydrofdiError",
        "report.table": "Table",
        "settings.ready": "schema",
    }.items()
    for name in names.split()
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
    "detect",
    "evaluate",
    "export",
    "indicators",
    "inspect",
    "load",
    "load_experiment",
    "measure",
    "plan",
    "replay",
    "report",
    "rerun",
    "schema",
    "simulate",
    "status",
    "sweep",
    "train",
    "verify",
    "why",
]


class _Room(ModuleType):
    """A room that has the name of a function, such as ``report``, and is called like it."""

    def __call__(self, *positional: Any, **keywords: Any) -> Any:
        name = self.__name__.removeprefix("hydrofdi.")
        return getattr(import_module(_HOMES[name]), name)(*positional, **keywords)


class _Package(ModuleType):
    def __setattr__(self, name: str, value: object) -> None:
        if isinstance(value, ModuleType) and name in _HOMES:
            value.__class__ = _Room
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        from hydrofdi.settings.messages import unknown_attribute

        raise unknown_attribute(sys.modules[__name__], name)
    return globals().setdefault(name, getattr(import_module(_HOMES[name]), name))


def __dir__() -> list[str]:
    return sorted(__all__)
