"""Functional mock-up units (FMUs): what they describe, and instances of them. FMPy reads and loads them."""

from __future__ import annotations

import hashlib
import math
import multiprocessing
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from hydrofdi.errors import ConfigError
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
    items : tuple of (str, int)
        Names and values of an enumeration.
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
    items: tuple[tuple[str, int], ...] = ()

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
            platforms = ", ".join(self.platforms)
            return f"has no binary for {fmpy.platform}, but for {platforms}; export it for this platform"
        return "" if self.platforms else "contains no binary; compile or export it for this platform"

    @property
    def takes_any_step(self) -> bool:
        """Whether communication steps may vary."""
        return bool(getattr(self.interface, "canHandleVariableCommunicationStepSize", True))

    @property
    def fixed_step(self) -> float | None:
        """Communication step of which it takes multiples alone [s]; None if it takes any."""
        stated = getattr(self.interface, "fixedInternalStepSize", None)
        return None if stated is None or self.takes_any_step else float(stated)

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
        with zipfile.ZipFile(path) as archive:
            if damaged := archive.testzip():
                raise zipfile.BadZipFile(f"{damaged} is damaged")
        source = fmpy.read_model_description(str(path), validate=False)
        platforms = fmpy.supported_platforms(str(path))
    except Exception as error:  # whatever a damaged archive or XML provokes in the libraries below
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ConfigError(f"{path}: is no FMU, or a damaged one: {reason}") from None
    if not source.fmiVersion.startswith(("2.", "3.")):
        raise ConfigError(f"{path}: is of FMI {source.fmiVersion}; export it as FMI 2 or 3")
    units = {unit.name: unit.baseUnit for unit in source.unitDefinitions or ()}
    is_second = source.fmiVersion.startswith("2.")
    variables = {each.name: _variable(each, units, is_second=is_second) for each in source.modelVariables}
    return Model(path, digest, source, variables, [name for name in platforms if name != "c-code"])


def _variable(given: Any, units: Mapping[str, Any], *, is_second: bool) -> Variable:
    stated = given.declaredType
    unit = given.unit or getattr(stated, "unit", None) or ""
    si_unit, factor, offset = _in_si(unit, units.get(unit))
    kind = {"Enumeration": "Integer" if is_second else "Int64"}.get(given.type, given.type)
    value: Any = {"Boolean": _boolean}.get(kind, _NUMBERS.get(kind, int))
    least, most = (
        _number(getattr(given, end) or getattr(stated, end, None)) if value in (float, int) else None
        for end in ("min", "max")
    )
    is_array = bool(given.dimensions)
    return Variable(
        given.name, given.valueReference, kind, given.causality or "local", given.variability or "",
        given.initial or "", unit, si_unit, factor, offset,
        None if is_array or given.start is None else value(given.start), least, most,
        given.description or "", is_array,
        tuple((item.name, int(item.value)) for item in getattr(stated, "items", None) or ()),
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


_TOLD = 1
"""Least status of a message that is kept: from ``warning`` on."""

_TOLERANCE = 1e-8
"""Largest relative tolerance of the solver of a model exchange."""


class PlantError(Exception):
    """An FMU refuses to go on; the text says what it told."""


@lru_cache(maxsize=4)
def instance_of(path: Path, digest: str, cache: Path | None) -> Instance:
    """The instance of an FMU in this process; its contents are kept in a cache, if there is one.

    Raises
    ------
    ConfigError
        The file is not the one with this SHA-256, or it cannot run here.
    """
    model = read_model(path)
    if model.digest != digest:
        raise ConfigError(f"{path}: has changed since the experiment was read")
    if model.obstacle:
        raise ConfigError(f"{path}: {model.obstacle}")
    return Instance(model, _unpacked(model, cache))


def _unpacked(model: Model, cache: Path | None) -> str:
    """Folder with the contents of an FMU; unpacked once for this user."""
    import fmpy

    folder = None if cache is None else cache / model.digest
    if folder is not None and folder.is_dir():
        return str(folder)
    part = tempfile.mkdtemp(prefix="hydrofdi-fmu-", dir=cache)
    fmpy.extract(str(model.path), part)
    if folder is None:
        return part
    try:
        os.rename(part, folder)  # whole or not at all
    except OSError:  # another process was first
        shutil.rmtree(part, ignore_errors=True)
    return str(folder)


class Instance:
    """An FMU that is run again and again, each time from its start.

    Each run has an instance of its own; one that can be made only once is reset.
    """

    def __init__(self, model: Model, folder: str) -> None:
        self.model, self._folder = model, folder
        if multiprocessing.parent_process() is not None:
            os.dup2(2, 1)  # what an FMU prints is no result
        self._is_second = model.source.fmiVersion.startswith("2.")
        self._fmu: Any = None
        self._solver: _Solver | None = None
        self._messages: list[str] = []

    def _heard(self, *told: Any) -> None:
        """Keep what the FMU says of errors; FMI 2 tells its name before the status."""
        status, message = told[2 if self._is_second else 1], told[-1]
        if status >= _TOLD and message:
            text = message.decode(errors="replace") if isinstance(message, bytes) else str(message)
            self._messages = [*self._messages[-3:], " ".join(text.split())]

    def start(self, values: Mapping[str, Any], inputs: Mapping[str, Any], stop_time: float) -> None:
        """Begin a run at t = 0 with start values and first inputs, in the units of the FMU.

        Raises
        ------
        PlantError
            The FMU refuses a value, or finds no initial state.
        """
        self._messages.clear()
        try:
            self._renew()
            self._initialise(values, inputs, stop_time)
        except Exception as error:
            raise self.failed(error) from None

    def _renew(self) -> None:
        from fmpy.simulation import instantiate_fmu

        self._solver, fmu = None, self._fmu
        if fmu is not None and self.model.interface.canBeInstantiatedOnlyOncePerProcess:
            try:
                fmu.reset()
            except Exception:  # not every FMU supports it
                self._free()
        elif fmu is not None and self._is_second:
            # Resets of some FMUs do nothing, or crash; a new instance on the loaded library takes 1 ms.
            fmu.fmi2FreeInstance(fmu.component)
            fmu.instantiate(callbacks=fmu.callbacks)
        elif fmu is not None:
            fmu.fmi3FreeInstance(fmu.component)
            fmu.instantiate(logMessage=self._heard)
        if self._fmu is None:
            self._fmu = instantiate_fmu(self._folder, self.model.source, logger=self._heard)

    def _initialise(self, values: Mapping[str, Any], inputs: Mapping[str, Any], stop_time: float) -> None:
        from fmpy.simulation import apply_start_values, settable_in_instantiated

        fmu, source = self._fmu, self.model.source
        if self._is_second:
            fmu.setupExperiment(startTime=0.0, stopTime=stop_time)
        later = apply_start_values(fmu, source, dict(values), settable=settable_in_instantiated)
        fmu.enterInitializationMode(**({} if self._is_second else {"startTime": 0.0, "stopTime": stop_time}))
        apply_start_values(fmu, source, later | dict(inputs))
        fmu.exitInitializationMode()
        if not self.model.is_co_simulation:
            self._solver = _Solver(self.model, fmu)

    def setter(self, names: Sequence[str]) -> Callable[[Sequence[float]], None]:
        """Function that sets inputs, given their values in the order of the names."""
        references = [self.model.variables[name].reference for name in names]
        write = self._fmu.setReal if self._is_second else self._fmu.setFloat64

        def set_inputs(values: Sequence[float]) -> None:
            write(references, values)
            if self._solver is not None:
                self._solver.has_jumped = True

        return set_inputs

    def getter(self, names: Sequence[str]) -> Callable[[], Sequence[float]]:
        """Function that returns the values of variables, in the order of the names."""
        variables = [self.model.variables[name] for name in names]
        readers = {variable.kind: getattr(self._fmu, f"get{variable.kind}") for variable in variables}
        if len(readers) == 1:
            ((_, read),), references = readers.items(), [variable.reference for variable in variables]
            return lambda: read(references)
        return lambda: [float(readers[variable.kind]([variable.reference])[0]) for variable in variables]

    @property
    def step(self) -> Callable[[float, float], object]:
        """Function that moves the FMU from a time over a step [s]; inputs are held meanwhile."""
        return self._fmu.doStep if self._solver is None else self._solver.step

    def failed(self, error: Exception) -> PlantError:
        """The failure of a run, after which a new FMU takes over."""
        told = "; ".join(dict.fromkeys(self._messages))
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        self._free()
        return PlantError(f"{reason.rstrip('.')}: {told}" if told else reason)

    def end(self) -> None:
        """End a run."""
        try:
            self._fmu.terminate()
        except Exception:  # its results are complete
            self._free()

    def _free(self) -> None:
        fmu, self._fmu, self._solver = self._fmu, None, None
        if fmu is not None:
            with suppress(Exception):  # what cannot be freed is lost with the process
                fmu.freeInstance()


class _Solver:
    """Model exchange by FMPy's CVODE: integrates from one communication point to the next."""

    def __init__(self, model: Model, fmu: Any) -> None:
        from fmpy.sundials import CVodeSolver

        self._fmu, self._is_second = fmu, model.source.fmiVersion.startswith("2.")
        self._completes = bool(model.source.modelExchange.needsCompletedIntegratorStep)
        self.has_jumped = False
        self._next_event = float("inf")
        self._settle()
        stated = model.source.defaultExperiment
        tolerance = float(stated.tolerance) if stated is not None and stated.tolerance else _TOLERANCE
        self._solver = CVodeSolver(
            nx=model.source.numberOfContinuousStates,
            nz=model.source.numberOfEventIndicators,
            get_x=fmu.getContinuousStates,
            set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives if self._is_second else fmu.getContinuousStateDerivatives,
            get_z=fmu.getEventIndicators,
            get_nominals=fmu.getNominalsOfContinuousStates,
            set_time=fmu.setTime,
            input=self,
            startTime=0.0,
            relativeTolerance=min(tolerance, _TOLERANCE),
            maxNumSteps=100_000,
        )

    def apply(self, time: float) -> None:
        """Apply no inputs: they are held between communication points."""

    def step(self, time: float, size: float) -> None:
        """Integrate over a step [s]; events may lie within."""
        end, rounding = time + size, 1e-9 * size
        if self.has_jumped or self._next_event <= time + rounding:
            self._event(time)
        while end - time > rounding:
            is_event, _, time = self._solver.step(time, min(end, self._next_event))
            self._fmu.setTime(time)
            if self._completes:
                entered, terminates = self._fmu.completedIntegratorStep()
                is_event = is_event or entered
                if terminates:
                    raise PlantError("the FMU ended the simulation")
            if is_event or self._next_event <= time + rounding:
                self._event(time)

    def _event(self, time: float) -> None:
        self.has_jumped = False
        self._fmu.enterEventMode()
        self._settle()
        self._solver.reset(time)

    def _settle(self) -> None:
        """Update the discrete states until they stay, and integrate again."""
        update = self._fmu.newDiscreteStates if self._is_second else self._fmu.updateDiscreteStates
        is_needed = True
        while is_needed:
            is_needed, terminates, _, _, is_defined, event = update()
            self._next_event = float(event) if is_defined else float("inf")
            if terminates:
                raise PlantError("the FMU ended the simulation")
        self._fmu.enterContinuousTimeMode()
