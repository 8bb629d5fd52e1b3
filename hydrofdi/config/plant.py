"""The section of a foreign plant: an FMU in the place of cylinder, valve and fluid."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self

from pydantic import ConfigDict, Field, ValidationInfo, WithJsonSchema, field_validator, model_validator

from hydrofdi.config.drive import ControlConfig, RecordConfig, is_whole
from hydrofdi.config.machine import LeakageConfig
from hydrofdi.errors import ConfigError
from hydrofdi.fmi import Model, Variable, digest_of, read_model
from hydrofdi.records import Channel
from hydrofdi.settings.files import located
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.units import parse_quantity, parse_unit, zero_of

INPUTS = {"input_voltage": "V", "reference_position": "m", "load_force": "N"}
"""Signal that drives a plant → its unit."""

SIGNAL_NAMES = {each: each.value for each in Channel} | {Channel.SUPPLY_PRESSURE: "valve_supply_pressure"}
"""Channel → its name among the signals of runs."""

OUTPUTS = {
    signal: channel.unit
    for channel, signal in SIGNAL_NAMES.items()
    if channel not in (Channel.RETURN_PRESSURE, Channel.INPUT_VOLTAGE)
} | {"internal_leakage_flow": "m^3/s"}
"""Signal that a plant gives → its unit."""

_OTHER_NAMES = {
    **{name: signal for channel, signal in SIGNAL_NAMES.items() for name in (channel.symbol, channel.value)},
    "internal_leakage": "internal_leakage_flow",
    "q_il": "internal_leakage_flow",
}
"""Symbol or other name → signal."""

_DIGEST = "#sha256:"
"""Between the path of an FMU that an experiment names, and what it contained."""

_STORED = re.compile(r"(?P<path>.*) \(sha256:(?P<digest>[0-9a-f]{64})\)", re.DOTALL)
"""An FMU that results name. It is never run."""

_WITH_UNIT = re.compile(r"(?P<name>.*\S)\s+\[(?P<unit>[^\[\]]+)\]")


def _schema(signals: Mapping[str, str]) -> WithJsonSchema:
    names = {
        "enum": [*signals, *(name for name, own in _OTHER_NAMES.items() if own in signals and name != own)]
    }
    variable = {"type": "string"}
    return WithJsonSchema({"type": "object", "propertyNames": names, "additionalProperties": variable})


class PlantVariable(NamedTuple):
    """A variable of an FMU, and how its values become SI: `factor` · value + `offset`."""

    name: str
    factor: float = 1.0
    offset: float = 0.0


class PlantLeakage(Section):
    """What sets the internal leakage of an FMU."""

    coefficient: str | None = None
    """Parameter of the FMU that ``leakage.internal_coefficient`` sets, and ``internal_flow``, for which it is
    solved. Its values need not be a K_i: any size that the leak grows with."""


class PlantConfig(Section):
    """An FMU in the place of cylinder, valve and fluid. Every other key is a parameter of the FMU, such as
    ``oil.beta: 551 MPa``; in a sweep it is ``plant.oil.beta``. The communication step is ``record.step``.
    """

    model_config = ConfigDict(extra="allow")

    fmu: str | None = None
    """File of FMI 2 or 3, relative to the experiment file that names it. It is foreign machine code and runs
    with your rights. Co-simulation is preferred; a model exchange is integrated by CVODE."""

    inputs: Annotated[Mapping[str, str], _schema(INPUTS)] = Field(default_factory=dict)
    """What drives the plant → variable of the FMU; ``reference_position`` is that of a controller inside it.
    ``'u [mV]'`` states the unit of a variable that has none, ``'u [0.1 V]'`` what 1 of it means, if 10 V are
    100 %."""

    outputs: Annotated[Mapping[str, str], _schema(OUTPUTS)] = Field(default_factory=dict)
    """Signal → variable of the FMU. ``'p1 [bar]'`` states the unit of a variable that has none."""

    parameters: Mapping[str, str] = Field(default_factory=dict)
    """Parameter of hydrofdi → parameter of the FMU that it sets: with ``fluid.bulk_modulus: oil.beta`` a grid
    over the bulk modulus is one over ``oil.beta``."""

    leakage: PlantLeakage = PlantLeakage()
    """What sets the internal leakage."""

    units: Mapping[str, str] = Field(default_factory=dict)
    """Parameter of the FMU → its SI unit; written by hydrofdi."""

    @field_validator("fmu")
    @classmethod
    def _known_file(cls, given: str | None, info: ValidationInfo) -> str | None:
        """The path and what the file contains; results keep both, but name no file to run."""
        path, _, digest = (given or "").partition(_DIGEST)
        if digest and info.context is not None:
            return f"{path} (sha256:{digest})"
        return given if given is None or info.context is not None else with_digest(given)

    @field_validator("inputs", "outputs", mode="before")
    @classmethod
    def _known_signals(cls, given: Any, info: ValidationInfo) -> Any:
        known = INPUTS if info.field_name == "inputs" else OUTPUTS
        if not isinstance(given, Mapping):
            raise ValueError("expected 'signal: variable' pairs")
        named = {_OTHER_NAMES.get(str(key), str(key)): value for key, value in given.items()}
        fmu = info.data.get("fmu")
        model = named_model(fmu) if fmu else None
        for key, text in named.items():
            if key not in known:
                raise ValueError(f"{key}: is no signal here{nearest(key, [*known])}")
            if model is not None:
                plant_variable(model, key, str(text))
        return named

    @model_validator(mode="after")
    def _variables_exist(self) -> Self:
        if self.fmu is None:
            if self != type(self).model_construct():
                raise ValueError("needs the key 'fmu', the path of an FMU")
            return self
        if (model := self.model) is None:
            for name, unit in self.units.items():
                PARAMETERS[f"plant.{name}"] = Variable(name, 0, "Float64", "parameter", "", "", si_unit=unit)
            return self
        if model.obstacle:
            raise ValueError(f"{self.name} cannot run here: it {model.obstacle}")
        if "chamber_1_pressure" not in self.outputs:
            raise ValueError("outputs: name the variable of chamber_1_pressure at least")
        leak = self.leakage.coefficient
        driven = [plant_variable(model, *pair).name for pair in self.inputs.items()]
        for name in self.own:
            if name in (leak, *driven, *self.parameters.values()):
                setter = "leakage.internal_coefficient" if name == leak else "inputs or parameters"
                raise ValueError(f"{name!r} is set by {setter}; state it there alone")
        for name in (*self.parameters.values(), *([leak] if leak else ()), *self.own):
            if not (variable := model.variable(name)).is_settable:
                raise ValueError(f"{name!r} cannot be set, as it is {_kind(variable)}")
        return self

    @property
    def own(self) -> dict[str, Any]:
        """Parameter of the FMU that is stated → its value in SI."""
        return self.__pydantic_extra__ or {}

    @property
    def model(self) -> Model | None:
        """The FMU, if the experiment itself names it; results and detectors do not."""
        return None if self.fmu is None else named_model(self.fmu)

    def takes(self, parameter: str) -> bool:
        """Whether a parameter of the own plant acts: all do without an FMU."""
        return self.fmu is None or parameter in self.parameters

    @property
    def takes_leakage(self) -> bool:
        """Whether ``leakage.internal_coefficient`` acts; else an FMU may leak by itself."""
        return self.fmu is None or self.leakage.coefficient is not None

    def __hash__(self) -> int:
        return hash(self.stated_text)

    @property
    def name(self) -> str:
        """File name of the FMU."""
        return Path((self.fmu or "").partition(_DIGEST)[0].partition(" (")[0]).name

    @property
    def digest(self) -> str:
        """SHA-256 of the FMU; empty without one."""
        stored = _STORED.fullmatch(self.fmu or "")
        return stored["digest"] if stored else (self.fmu or "").partition(_DIGEST)[2]

    def stated(self) -> dict[str, Any]:
        """The fields that differ from their defaults; the FMU by the digest of its contents."""
        fields = super().stated()
        return fields if self.fmu is None else fields | {"fmu": f"sha256:{self.digest}"}

    def variable(self, signal: str) -> PlantVariable:
        """The variable of an input or output, with its conversion to SI."""
        assert self.model is not None
        return plant_variable(self.model, signal, {**self.inputs, **self.outputs}[signal])


def with_digest(path: str) -> str:
    """The whole path of an FMU, and what the file contains; one that has both as it is."""
    if _DIGEST in path or _STORED.fullmatch(path):
        return path
    file = located(Path(path)).resolve()
    return f"{file}{_DIGEST}{digest_of(file)}"


@lru_cache(maxsize=16)
def named_model(fmu: str) -> Model | None:
    """The FMU of a path with a digest, a ConfigError if it is another one by now; None of one in results."""
    if _STORED.fullmatch(fmu):
        return None
    path, _, digest = fmu.partition(_DIGEST)
    model = read_model(Path(path))
    if model.digest != digest:
        raise ConfigError(f"{path}: has changed since the experiment was read")
    return model


def _kind(port: Variable) -> str:
    """What a variable is, in the words of FMI."""
    return " ".join(filter(None, ("an array" if port.is_array else "", port.variability, port.causality)))


def plant_variable(model: Model, signal: str, text: str) -> PlantVariable:
    """The variable that a text names, with its conversion to SI; a ValueError if it is not such a signal."""
    needed = {**INPUTS, **OUTPUTS}[signal]
    written = None if text in model.variables else _WITH_UNIT.fullmatch(text)
    port = model.variable(written["name"] if written else text)
    if signal in INPUTS and port.causality != "input":
        raise ValueError(f"{signal}: {port.name!r} is no input of the FMU, but {_kind(port)}")
    if port.is_array or port.value_type is str:
        raise ValueError(f"{signal}: {port.name!r} is no single number")
    if written:
        unit = written["unit"]
        if "…" in unit:
            raise ValueError(f"{signal}: state the unit of {port.name!r}, such as '{port.name} [{needed}]'")
        if port.si_unit != "1":
            raise ValueError(f"{signal}: {port.name!r} is in {port.unit}; leave [{unit}] out")
        one = unit if unit[0].isdigit() else f"1 {unit}"  # or what 1 means, such as 0.1 V
        return PlantVariable(port.name, parse_quantity(one, needed), zero_of(unit))
    is_known = port.si_unit != "1" or port.unit not in ("", "1", "-")
    if is_known and parse_unit(port.si_unit).exponents != parse_unit(needed).exponents:
        raise ValueError(
            f"{signal} needs {needed}; {port.name!r} is in {port.unit}: state what 1 {port.unit} means, as"
            f" in '{port.name} [0.1 {needed}]'"
        )
    return PlantVariable(port.name, port.factor, port.offset)


PARAMETERS: dict[str, Variable] = {}
"""Dotted parameter of the FMU of the experiment that is at work → its variable, as far as it is known."""


def is_foreign(name: Any) -> bool:
    """Whether a dotted name is that of a parameter of an FMU."""
    section, _, field = name.partition(".") if isinstance(name, str) else ("", "", "")
    return section == "plant" and bool(field) and field not in PlantConfig.model_fields


def declare(model: Model) -> None:
    """Make the parameters of an FMU known by their dotted names, and those of no other."""
    PARAMETERS.clear()
    settable = (each for each in model.variables.values() if each.is_settable)
    PARAMETERS.update((f"plant.{each.name}", each) for each in settable)


def foreign_quantity(name: str) -> SI | None:
    """Unit and limits of a parameter of an FMU; None if it is not a quantity."""
    declared = PARAMETERS.get(name)
    if declared is None or declared.value_type is not float:
        return None
    low, high = (None if end is None else declared.in_si(end) for end in (declared.least, declared.most))
    return SI(declared.si_unit, least=low, most=high)


def foreign_start(name: str) -> Any:
    """The value in SI that a parameter of an FMU has without being stated; None if it has none."""
    declared = PARAMETERS.get(name)
    return None if declared is None or declared.start is None else declared.in_si(declared.start)


def foreign_value(name: str, value: Any) -> Any:
    """A value of a parameter of an FMU in SI; a ValueError if it has none like this."""
    if (declared := PARAMETERS.get(name)) is None:
        raise ValueError(f"no parameter of the FMU{nearest(name, [*PARAMETERS])}")
    if (quantity := foreign_quantity(name)) is not None:
        return quantity.parse(value)
    named = dict(declared.items)
    if named and value not in named.values():
        if value not in named:
            raise ValueError(f"expected one of {', '.join(named)}; found {value!r}")
        value = named[value]
    is_number = isinstance(value, int) and not isinstance(value, bool)
    kind, low, high = declared.value_type, declared.least, declared.most
    if not (is_number if kind is int else isinstance(value, kind)):
        raise ValueError(f"expected {kind.__name__}; found {value!r}")
    if (low is not None and value < low) or (high is not None and value > high):
        raise ValueError(f"must be from {low} to {high}; found {value}")
    return value


def absent_signals(plant: PlantConfig) -> frozenset[str]:
    """Signals that runs on an FMU lack; none without one."""
    return frozenset(OUTPUTS.keys() - plant.outputs.keys() if plant.fmu is not None else ())


def require_plant_fits(
    plant: PlantConfig, control: ControlConfig, leakage: LeakageConfig, record: RecordConfig
) -> None:
    """An FMU has the variables that the controller and the leak need, and takes the communication step."""
    if plant.fmu is None:
        return
    fixed = plant.model.fixed_step if plant.model is not None else None
    if fixed is not None and not is_whole(record.step / fixed):
        raise ValueError(
            f"record.step = {record.step:g} s is not a multiple of the {fixed:g} s that {plant.name} takes"
        )
    is_inside = "reference_position" in plant.inputs
    if control.is_closed and not is_inside and "piston_position" not in plant.outputs:
        raise ValueError(f"control.law = {control.law} reads the position: name it in plant.outputs")
    if not (is_inside or "input_voltage" in plant.inputs):
        raise ValueError("plant.inputs needs input_voltage, or reference_position of a controller inside")
    if (leakage.internal_coefficient or leakage.internal_flow) and plant.leakage.coefficient is None:
        raise ValueError("an internal leak needs plant.leakage.coefficient, the parameter that sets it")
    if leakage.internal_flow and "internal_leakage_flow" not in plant.outputs:
        raise ValueError(
            "leakage.internal_flow is solved from the flow of the leak, which is not among plant.outputs:"
            " name it as internal_leakage_flow, or state leakage.internal_coefficient"
        )
