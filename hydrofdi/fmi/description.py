"""The model description of an FMU: its variables with units, and what speaks against running it here."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.settings.quantities import SI
from hydrofdi.units import BASE_UNITS, SYMBOLS, parse_unit, zero_of

EXTRA = "FMUs need the extra: pip install 'hydrofdi[fmi]'"

_POWER = re.compile(r"(?<=[A-Za-z])(-?\d+)")

_NUMBERS = {"Real": float, "Float64": float, "Float32": float, "Boolean": bool, "String": str}
"""Type of a variable → that of its values; all others are integers."""

_NAMED = ("Pa", "m/s", "m^3/s", "m^3", "m^2", "N/m", "N*s/m", "kg/m^3", "Pa*s", "m^3/(s*Pa)", "m/V", "m^2/s")
"""Units of SI that have a name of their own in this field, besides single symbols."""


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU.

    Attributes
    ----------
    unit : str
        As the FMU names it; empty if it names none.
    si_unit : str
        The SI unit of its dimension; ``1`` without a unit.
    factor, offset : float
        Value in SI = `factor` · value + `offset`.
    start, least, most : Any
        In the unit of the FMU; None if it states none.
    items : tuple of int
        Values of an enumeration.
    """

    name: str
    reference: int
    kind: str
    causality: str
    variability: str
    initial: str
    unit: str = ""
    si_unit: str = "1"
    factor: float = 1.0
    offset: float = 0.0
    start: Any = None
    least: float | None = None
    most: float | None = None
    text: str = ""
    is_array: bool = False
    items: tuple[int, ...] = ()

    @property
    def value_type(self) -> type:
        """Type of its values."""
        return _NUMBERS.get(self.kind, int)

    @property
    def is_settable(self) -> bool:
        """Whether a run may set its start value."""
        has_own = self.initial in ("exact", "approx") or (not self.initial and self.start is not None)
        is_free = self.causality in ("parameter", "structuralParameter", "input")
        return not self.is_array and self.variability != "constant" and (is_free or has_own)

    @property
    def quantity(self) -> SI | None:
        """Unit and limits of its values in SI; None if they are no real numbers."""
        if self.value_type is not float:
            return None
        low, high = (None if end is None else self.in_si(end) for end in (self.least, self.most))
        return SI(self.si_unit, least=low, most=high)

    def in_si(self, value: Any) -> Any:
        """A value of the FMU in SI."""
        return self.factor * value + self.offset if self.value_type is float else value

    def own(self, value: Any) -> Any:
        """A value in SI in the unit of the FMU."""
        return (value - self.offset) / self.factor if self.value_type is float else value


@dataclass(frozen=True)
class Model:
    """What an FMU says of itself.

    Attributes
    ----------
    path : Path
        The FMU.
    digest : str
        SHA-256 of the file.
    source : object
        The model description of FMPy.
    variables : dict
        Name → variable.
    platforms : list of str
        Those that it has a binary for.
    """

    path: Path
    digest: str
    source: Any
    variables: Mapping[str, Variable]
    platforms: list[str]

    @property
    def is_co_simulation(self) -> bool:
        """Whether it contains its solver."""
        return self.source.coSimulation is not None

    @property
    def interface(self) -> Any:
        """Its co-simulation, else its model exchange."""
        return self.source.coSimulation if self.is_co_simulation else self.source.modelExchange

    @cached_property
    def obstacle(self) -> str:
        """Why it cannot run here; empty if it can."""
        import fmpy

        if self.interface is None:
            return "has neither co-simulation nor model exchange; export one of them"
        if self.platforms and fmpy.platform not in self.platforms:
            found = ", ".join(self.platforms)
            return f"has no binary for {fmpy.platform}, but for {found}; export it for this platform"
        return "" if self.platforms else "contains no binary; compile or export it for this platform"

    @property
    def fixed_step(self) -> float | None:
        """Communication step of which it takes multiples alone [s]; None if it takes any."""
        stated = getattr(self.interface, "fixedInternalStepSize", None)
        is_free = getattr(self.interface, "canHandleVariableCommunicationStepSize", True)
        return None if stated is None or is_free else float(stated)

    @property
    def needed_tool(self) -> str:
        """What has to be installed while it runs; empty if nothing has."""
        tool = self.source.generationTool or "the tool that made it"
        return tool if self.interface is not None and self.interface.needsExecutionTool else ""

    def variable(self, name: str) -> Variable:
        """The variable of a name; else a ValueError names the nearest."""
        if name not in self.variables:
            alike = get_close_matches(name, self.variables, 1)
            meant = f"; did you mean {alike[0]!r}?" if alike else f"; 'hydrofdi inspect {self.path.name}'"
            raise ValueError(f"{self.path.name} has no variable {name!r}{meant}")
        return self.variables[name]


def digest_of(path: Path) -> str:
    """SHA-256 of a file."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None


def read_model(path: Path) -> Model:
    """What an FMU says of itself; nothing of it is executed.

    Raises
    ------
    ConfigError
        It is no FMU of version 2 or 3, cannot be read, or FMPy is not installed.
    """
    return _read(path, digest_of(path))


@lru_cache(maxsize=16)
def _read(path: Path, digest: str) -> Model:
    try:
        import fmpy
    except ImportError:
        raise ConfigError(f"{path}: {EXTRA}") from None
    try:
        source = fmpy.read_model_description(str(path), validate=False)
        platforms = fmpy.supported_platforms(str(path))
    except Exception as error:  # whatever a damaged archive or XML provokes in the libraries below
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ConfigError(f"{path}: is no FMU that can be read: {reason}") from None
    if not source.fmiVersion.startswith(("2.", "3.")):
        raise ConfigError(f"{path}: is of FMI {source.fmiVersion}; export it as FMI 2 or 3")
    units = {unit.name: unit.baseUnit for unit in source.unitDefinitions or ()}
    is_second = source.fmiVersion.startswith("2.")
    variables = {each.name: _variable(each, units, is_second=is_second) for each in source.modelVariables}
    return Model(path, digest, source, variables, [each for each in platforms if each != "c-code"])


def _variable(given: Any, units: Mapping[str, Any], *, is_second: bool) -> Variable:
    stated = given.declaredType
    unit = given.unit or getattr(stated, "unit", None) or ""
    si_unit, factor, offset = _in_si(unit, units.get(unit))
    kind = {"Enumeration": "Integer" if is_second else "Int64"}.get(given.type, given.type)
    value: Any = {"Boolean": _boolean}.get(kind, _NUMBERS.get(kind, int))
    least, most = (
        _number(getattr(given, end) or getattr(stated, end, None)) if kind in ("Real", "Float64") else None
        for end in ("min", "max")
    )
    is_array = bool(given.dimensions)
    return Variable(
        given.name, given.valueReference, kind, given.causality or "local", given.variability or "",
        given.initial or "", unit, si_unit, factor, offset,
        None if is_array or given.start is None else value(given.start), least, most,
        given.description or "", is_array,
        tuple(int(item.value) for item in getattr(stated, "items", None) or ()),
    )  # fmt: skip


def _number(text: Any) -> float | None:
    value = None if text is None else float(text)
    return value if value is not None and math.isfinite(value) else None


def _boolean(text: Any) -> bool:
    return str(text).lower() in ("true", "1")


def _in_si(unit: str, base: Any) -> tuple[str, float, float]:
    """SI unit, factor and offset of a unit of an FMU; one without a definition that is unknown is 1."""
    if base is not None:
        exponents = tuple(Fraction(getattr(base, name)) for name in BASE_UNITS)
        if not (base.mol or base.cd):
            return _si_unit(exponents), float(base.factor), float(base.offset)
    # Modelica writes N.m and m3/s.
    for written in (unit, _POWER.sub(r"^\1", unit).replace(".", "·")):
        with suppress(ValueError):
            known = parse_unit(written)
            return _si_unit(known.exponents), float(known.factor), zero_of(unit)
    return "1", 1.0, 0.0


@lru_cache(maxsize=256)
def _si_unit(exponents: tuple[Fraction, ...]) -> str:
    """The SI unit of a dimension, by its usual name."""
    for name in (*(symbol for symbol, unit in SYMBOLS.items() if unit.factor == 1), *_NAMED):
        if parse_unit(name).exponents == exponents:
            return name
    powers = zip(BASE_UNITS, exponents, strict=True)
    return "*".join(f"{base}^{power}" for base, power in powers if power)
