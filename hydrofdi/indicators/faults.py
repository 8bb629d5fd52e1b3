"""Faults of indicators, including third-party ones, and doubts about their numbers, reported as messages.

Doubtful are estimates that no machine has, and models that do not explain it.
"""

from __future__ import annotations

import inspect
import math
import re
import traceback
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from hydrofdi.errors import Issue
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.messages import shown_quantity
from hydrofdi.settings.quantities import Section

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
_TAKEN = {"analysis_id", "obstacle"}
"""Output names that are reserved in files."""


class FaultyIndicatorError(Exception):
    """An indicator cannot be measured because of a fault in its code."""


def raised(indicator: Indicator[Any], error: Exception) -> FaultyIndicatorError:
    """Error for an indicator that raised an exception, with the line of its module."""
    text = " ".join(str(error).split())
    what = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return FaultyIndicatorError(f"indicator {indicator.name!r} raised {what}{_place(indicator, error)}")


def tells_fault(obstacle: str) -> bool:
    """Whether an obstacle is a fault of the indicator, not of the record."""
    return obstacle.startswith("indicator '")


def _place(indicator: Indicator[Any], error: Exception) -> str:
    """File and line in the indicator's module where an exception came from; empty if unknown."""
    code = getattr(inspect.unwrap(type(indicator).measure), "__code__", None)
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if code and frame.filename == code.co_filename]
    return f" ({Path(code.co_filename).name}:{lines[-1]})" if code and lines else ""


def fault_of_outputs(measured: Any, indicator: Indicator[Any], n_record: int) -> str:
    """How the values of an indicator differ from its declared outputs; empty if they do not."""
    if not isinstance(measured, Mapping):
        return f"{type(measured).__name__}, not a mapping of its outputs"
    expected = {output.name: (n_record, *output.dims.values()) for output in indicator.outputs}
    for name in {**expected, **measured}:
        array: Any = measured.get(name)
        if name not in expected:
            return f"{name!r}, which is not one of its outputs"
        is_array = isinstance(array, np.ndarray)
        if not is_array or array.shape != expected[name] or array.dtype.kind != "f":
            kind = f"{array.dtype} of shape {array.shape}" if is_array else type(array).__name__
            return f"{name!r} as {kind}, not as real floating-point numbers of shape {expected[name]}"
    return ""


def fault_of_declaration(indicator: Indicator[Any]) -> str:
    """What is wrong with the channels and outputs that an indicator declares; empty if nothing is."""
    if not all(isinstance(channel, Channel) for channel in frozenset(indicator.channels)):
        return "its channels are not a set of Channel"
    outputs = tuple(indicator.outputs)
    if not outputs:
        return "it has no outputs"
    if not all(isinstance(output, Output) for output in outputs):
        return "its outputs are not a tuple of Output"
    names = [output.name for output in outputs]
    for name in (*names, *{dimension for output in outputs for dimension in output.dims}):
        if not _NAME.fullmatch(name) or name in _TAKEN:
            return f"{name!r} is not a valid name of an output or a dimension; use letters, digits and _"
    if twice := [name for name in names if names.count(name) > 1]:
        return f"it has two outputs {twice[0]!r}"
    return ""


CHANNELS = ("channels", "optional_channels")
"""Attributes with the channels of an indicator."""

OUTPUTS = TypeAdapter(tuple[Output, ...])
"""Outputs of an indicator as JSON, for readers without its code."""


class _StoredOptions(Section, extra="allow"):
    """Options of an indicator that is not installed."""


class AbsentIndicator(Indicator[Any]):
    """Placeholder for an indicator that is not installed: what a file says of it, if anything."""

    name, version, summary, source = "absent", 0, "An indicator that is not installed.", "none"
    channels = optional_channels = frozenset[Channel]()
    outputs = ()

    def __init__(self, reason: str, stored: Mapping[str, Any] | None = None) -> None:
        super().__init__()
        self.reason = reason
        if stored and "outputs" in stored:
            of_file: Any = {"name": str(stored["indicator"]), "version": int(stored["version"])}
            of_file["options"] = _StoredOptions.model_validate_json(stored["options"])
            of_file |= {kind: frozenset(map(Channel, stored[kind].split())) for kind in CHANNELS}
            vars(self).update(of_file, outputs=OUTPUTS.validate_json(stored["outputs"]))

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message that the indicator is not installed."""
        return self.reason

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """No values."""
        return {}


CAUSES = (
    "is a sign, the zero of the position or a constant of the actuator wrong, or are two channels swapped?"
)

OF_LEAKS = ("misfit", "incompressible")
"""Kinds of doubts that a leak of another law than the model's raises itself."""

POSITIVE = (0.0, None)
"""Possible values of a quantity that can only be positive."""

FLUID = (0.1e9, 3e9)
"""Bulk moduli of a fluid in a machine [Pa]."""

_ANY = (-math.inf, math.inf)

_UNEXPLAINED = 10.0
"""Factor of the largest misfit beyond which numbers say nothing, as if channels were swapped; a choice."""

_DEVIATIONS = 4.0
"""Standard deviations by which an estimate must lie below its lowest possible value."""


def doubts_of(
    indicator: Indicator[Any],
    values: Mapping[str, Array],
    prefix: str = "",
    fits: Mapping[str, float] | None = None,
) -> list[tuple[Issue, ...]]:
    """Doubts about each record; none about records without any number.

    Parameters
    ----------
    values : mapping of str to ndarray, shape (n_record, ...)
        Its outputs by name; outputs that are not there are not checked.
    prefix : str
        Prefix of these names.
    fits : mapping of str to float, optional
        Largest values with which the model explains a record, where they are not those of the outputs.
    """
    outputs = [each for each in indicator.outputs if prefix + each.name in values and not each.dims]
    own = {each.name: values[prefix + each.name] for each in outputs}
    doubts: list[list[Issue]] = [[] for _ in next(iter(own.values()), ())]
    is_measured = np.isfinite([*own.values()]).any(axis=0) if own else np.array([])
    for output in outputs:
        if output.possible == (None, None):
            continue
        low, high = (
            end if given is None else given for given, end in zip(output.possible, _ANY, strict=True)
        )
        learned = (fits or {}).get(prefix + output.name, high)
        value, slack = own[output.name], _DEVIATIONS * own[output.error] if output.error else 0.0
        is_possible = ~(value > learned) if output.is_fit else (value >= low - slack) & (value <= high)
        for row in np.flatnonzero(is_measured & ~is_possible).tolist():
            doubts[row].append(_doubt(output, float(value[row]), high, learned, prefix))
    return [tuple(each) for each in doubts]


def _doubt(output: Output, value: float, high: float, learned: float, prefix: str) -> Issue:
    name, shown = prefix + output.name, shown_quantity(value, output.unit)
    if output.is_fit:
        limit = f"{learned:.3g}" + " of all healthy windows" * (learned > high)
        text = f"{name} = {shown} exceeds {limit}: the model does not explain these records"
        if output.name == "misfit" and learned == high:
            text += ", or its option 'error' is too small for their sensors"
        return Issue(text, name, kind="unexplained" if value > _UNEXPLAINED * learned else "misfit")
    if value > high:
        causes = "is there a large leak, or is a volume wrong?"
        return Issue(f"{name}: no compressibility is visible; {causes}", name, kind="incompressible")
    if output.is_positive and not value > 0.0:
        return Issue(f"{name} is not positive: {CAUSES}", name, kind="not_positive")
    return Issue(f"{name} = {shown} is physically impossible: {CAUSES}", name, kind="impossible")


def summaries(found: Iterable[Issue], n_record: int) -> Iterator[str]:
    """A sentence on each doubtful output, with the number of its records and the first reason.

    Parameters
    ----------
    found : iterable of Issue
        Of all records.
    n_record : int
        Number of records with numbers.
    """
    of: dict[str, list[Issue]] = {}
    for doubt in found:
        of.setdefault(doubt.where, []).append(doubt)
    for some in of.values():
        yield f"doubtful: {len(some):,} of {n_record:,} records, such as {some[0].message}"
