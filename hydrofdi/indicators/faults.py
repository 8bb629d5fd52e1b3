"""Faults of indicators, most of which other people write: each becomes a sentence, never a number."""

from __future__ import annotations

import inspect
import re
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import ConfigError
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Channel
from hydrofdi.settings.quantities import Section

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
_TAKEN = {"analysis_id", "obstacle"}
"""Names that a file gives to what it says of an indicator itself."""


class FaultyIndicatorError(Exception):
    """An indicator cannot be measured through a fault of its own."""


def raised(indicator: Indicator[Any], error: Exception) -> FaultyIndicatorError:
    """The fault of an indicator that raised an exception, with the line of its module."""
    text = " ".join(str(error).split())
    what = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return FaultyIndicatorError(f"indicator {indicator.name!r} raised {what}{_place(indicator, error)}")


def gives_infinite(indicator: Indicator[Any]) -> str:
    """The fault of an indicator in a record of which it gives infinite numbers alone."""
    return f"indicator {indicator.name!r} gives infinite numbers"


def tells_fault(obstacle: str) -> bool:
    """Whether an indicator has no value because of its own fault, not the record's."""
    return obstacle.startswith("indicator '")


def _place(indicator: Indicator[Any], error: Exception) -> str:
    """Where in the indicator's own module an exception came from; empty if that is not known."""
    code = getattr(inspect.unwrap(type(indicator).measure), "__code__", None)
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if code and frame.filename == code.co_filename]
    return f" ({Path(code.co_filename).name}:{lines[-1]})" if code and lines else ""


def require_sound_outputs(measured: Any, indicator: Indicator[Any], n_record: int) -> None:
    """Check what an indicator gave against what it says that it gives.

    Raises
    ------
    FaultyIndicatorError
        Outputs are missing or unknown, or one is no array of floating numbers of its shape.
    """
    fault = _fault_of_outputs(measured, indicator, n_record)
    if fault:
        raise FaultyIndicatorError(f"indicator {indicator.name!r} gives {fault}")


def _fault_of_outputs(measured: Any, indicator: Indicator[Any], n_record: int) -> str:
    if not isinstance(measured, Mapping):
        return f"{type(measured).__name__}, not a mapping of its outputs"
    expected = {output.name: (n_record, *output.dims.values()) for output in indicator.outputs}
    if missing := [name for name in expected if name not in measured]:
        return f"no {' and no '.join(map(repr, missing))}"
    if unknown := [name for name in measured if name not in expected]:
        return f"{unknown[0]!r}, which is none of its outputs"
    for name, shape in expected.items():
        if not isinstance(measured[name], np.ndarray):
            return f"{name!r} as {type(measured[name]).__name__}, not as an array of shape {shape}"
        if measured[name].shape != shape:
            return f"{name!r} of shape {measured[name].shape}, not {shape}"
        if measured[name].dtype.kind != "f":
            return f"{name!r} of type {measured[name].dtype}, not of real floating numbers"
    return ""


def made_soundly(kind: type[Indicator[Any]], name: str, options: Section) -> Indicator[Any]:
    """An indicator of a class, once what it says of itself has been checked.

    Raises
    ------
    ConfigError
        It cannot be made, has no outputs or not of the kind that files can hold, or needs what is no channel.
    """
    try:
        indicator = kind(options)
        fault = _fault_of_declaration(indicator)
    except Exception as error:
        raise ConfigError(f"indicator {name!r} is faulty: {type(error).__name__}: {error}") from error
    if fault:
        raise ConfigError(f"indicator {name!r} is faulty: {fault}")
    return indicator


def _fault_of_declaration(indicator: Indicator[Any]) -> str:
    if not all(isinstance(channel, Channel) for channel in frozenset(indicator.channels)):
        return "its channels are no set of Channel"
    outputs = tuple(indicator.outputs)
    if not outputs:
        return "it has no outputs"
    if not all(isinstance(output, Output) for output in outputs):
        return "its outputs are no tuple of Output"
    names = [output.name for output in outputs]
    for name in (*names, *{dimension for output in outputs for dimension in output.dims}):
        if not _NAME.fullmatch(name) or name in _TAKEN:
            return f"{name!r} is not a valid name of an output or a dimension; use letters, digits and _"
    if twice := [name for name in names if names.count(name) > 1]:
        return f"it has two outputs {twice[0]!r}"
    return ""
