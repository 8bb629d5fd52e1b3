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

from hydrofdi.version import __version__ as __version__

if TYPE_CHECKING:
    from hydrofdi.api.detector import Detector as Detector
    from hydrofdi.api.detector import detect as detect
    from hydrofdi.api.detector import train as train
    from hydrofdi.api.diagnosis import diagnose as diagnose
    from hydrofdi.api.diagnosis import trend as trend
    from hydrofdi.api.evaluation import evaluate as evaluate
    from hydrofdi.api.records import export as export
    from hydrofdi.api.records import indicators as indicators
    from hydrofdi.api.records import inspect as inspect
    from hydrofdi.api.records import measure as measure
    from hydrofdi.api.results import Results as Results
    from hydrofdi.api.results import load as load
    from hydrofdi.api.results import report as report
    from hydrofdi.api.run import Run as Run
    from hydrofdi.api.run import simulate as simulate
    from hydrofdi.api.starting import configs as configs
    from hydrofdi.api.starting import init as init
    from hydrofdi.api.streams import monitor_fleet as monitor_fleet
    from hydrofdi.api.streams import replay as replay
    from hydrofdi.api.sweeps import calibrate as calibrate
    from hydrofdi.api.sweeps import check as check
    from hydrofdi.api.sweeps import collect as collect
    from hydrofdi.api.sweeps import plan as plan
    from hydrofdi.api.sweeps import sweep as sweep
    from hydrofdi.config import load_experiment as load_experiment
    from hydrofdi.diagnosis.diagnosing import Diagnosis as Diagnosis
    from hydrofdi.errors import HydrofdiError as HydrofdiError
    from hydrofdi.execution.exporting import Exported as Exported
    from hydrofdi.execution.folders import rerun as rerun
    from hydrofdi.execution.folders import status as status
    from hydrofdi.execution.folders import verify as verify
    from hydrofdi.execution.folders import why as why
    from hydrofdi.report.detection.evaluation import Evaluation as Evaluation
    from hydrofdi.report.inspection import Inspection as Inspection
    from hydrofdi.settings.files import schema as schema
    from hydrofdi.tables.table import Table as Table

_HOMES = {
    name: f"hydrofdi.{module}"
    for module, names in {
        "api.detector": "Detector detect train",
        "api.diagnosis": "diagnose trend",
        "api.evaluation": "evaluate",
        "api.records": "export indicators inspect measure",
        "api.results": "Results load report",
        "api.run": "Run simulate",
        "api.starting": "configs init",
        "api.streams": "monitor_fleet replay",
        "api.sweeps": "calibrate check collect plan sweep",
        "config": "load_experiment",
        "diagnosis.diagnosing": "Diagnosis",
        "errors": "HydrofdiError",
        "execution.exporting": "Exported",
        "execution.folders": "rerun status verify why",
        "report.detection.evaluation": "Evaluation",
        "report.inspection": "Inspection",
        "settings.files": "schema",
        "tables.table": "Table",
    }.items()
    for name in names.split()
}
"""Name → module that it is loaded from when it is first used."""

__all__ = sorted(["__version__", *_HOMES])


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
        raise AttributeError(f"hydrofdi has no attribute {name!r}", name=name, obj=sys.modules[__name__])
    return globals().setdefault(name, getattr(import_module(_HOMES[name]), name))


def __dir__() -> list[str]:
    return sorted(__all__)
