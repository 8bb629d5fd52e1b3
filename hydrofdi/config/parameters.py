"""All that determines one run, and access to it by dotted names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Annotated, Any, Self

from pydantic import TypeAdapter, model_validator
from pydantic.fields import FieldInfo

from hydrofdi.config.sections.actuator import ActuatorConfig
from hydrofdi.config.sections.control import ControlConfig
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.sections.fit import (
    require_fluid_fits,
    require_input_fits,
    require_jitter_fits,
    require_load_fits,
    require_record_fits,
)
from hydrofdi.config.sections.fluid import FluidConfig
from hydrofdi.config.sections.friction import FrictionConfig
from hydrofdi.config.sections.input import InputConfig
from hydrofdi.config.sections.leakage import LeakageConfig
from hydrofdi.config.sections.load import LoadConfig
from hydrofdi.config.sections.run import RunConfig
from hydrofdi.config.sections.sensor import (
    LengthSensorConfig,
    MeasurementConfig,
    PressureSensorConfig,
    SensorConfig,
    VelocitySensorConfig,
    VoltageSensorConfig,
)
from hydrofdi.config.sections.supply import SupplyConfig
from hydrofdi.config.sections.valve import ValveConfig
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.transforms.configuration import WaveletConfig


class RunParameters(Section):
    """The validated sections of one run, in SI."""

    actuator: ActuatorConfig = ActuatorConfig()
    """Cylinder and load."""
    supply: SupplyConfig = SupplyConfig()
    """Supply and return pressure."""
    fluid: FluidConfig = FluidConfig()
    """Fluid."""
    valve: ValveConfig = ValveConfig()
    """Servovalve."""
    friction: FrictionConfig = FrictionConfig()
    """Friction."""
    leakage: LeakageConfig = LeakageConfig()
    """Internal and external leakage."""
    input: InputConfig = InputConfig()
    """Drive voltage, or reference of a controller."""
    control: ControlConfig = ControlConfig()
    """Open loop, or position control."""
    load: LoadConfig = LoadConfig()
    """Force on the piston."""
    run: RunConfig = RunConfig()
    """Integration and sampling."""
    wavelet: WaveletConfig = WaveletConfig()
    """Wavelet transform."""
    measurement: MeasurementConfig = MeasurementConfig()
    """What the sensors share."""
    pressure_1_sensor: PressureSensorConfig = PressureSensorConfig()
    """Sensor of the chamber-1 pressure."""
    pressure_2_sensor: PressureSensorConfig = PressureSensorConfig()
    """Sensor of the chamber-2 pressure."""
    supply_sensor: PressureSensorConfig = PressureSensorConfig()
    """Sensor of the supply pressure."""
    position_sensor: LengthSensorConfig = LengthSensorConfig()
    """Sensor of the piston position."""
    velocity_sensor: VelocitySensorConfig = VelocitySensorConfig()
    """Sensor of the piston velocity."""
    spool_sensor: LengthSensorConfig = LengthSensorConfig()
    """Sensor of the spool position."""
    voltage_sensor: VoltageSensorConfig = VoltageSensorConfig()
    """Sensor of the input voltage."""

    @model_validator(mode="after")
    def _sections_fit_each_other(self) -> Self:
        self._require_fit()
        return self

    def with_values(self, values: Mapping[str, Any]) -> RunParameters:
        """These parameters with the dotted names in `values` replaced.

        Either form of the internal leakage replaces the other.

        Raises
        ------
        ValueError
            The values are invalid, or do not fit each other.
        """
        return self.with_sections(self.changed_sections(values))

    def changed_sections(self, values: Mapping[str, Any]) -> dict[str, Section]:
        """The sections that dotted values change, as they become.

        Raises
        ------
        ValueError
            The values are invalid.
        """
        changed: dict[str, list[tuple[str, Any]]] = {}
        for name, value in values.items():
            section, field = name.split(".")
            changed.setdefault(section, []).append((field, value))
        return {name: replace_fields(self.__dict__[name], tuple(fields)) for name, fields in changed.items()}

    def with_sections(self, sections: Mapping[str, Section]) -> RunParameters:
        """These parameters with valid sections replaced.

        Raises
        ------
        ValueError
            The sections do not fit each other.
        """
        moved = self.with_valid_sections(sections)
        for fitting in FITTING_SECTIONS:
            if not sections.keys().isdisjoint(fitting):
                moved.require_fit(fitting)
        return moved

    def with_valid_sections(self, sections: Mapping[str, Section]) -> RunParameters:
        """These parameters with sections replaced that are known to fit."""
        moved = RunParameters.__new__(RunParameters)
        object.__setattr__(moved, "__dict__", {**self.__dict__, **sections})
        object.__setattr__(moved, "__pydantic_fields_set__", _ALL_SECTIONS)
        object.__setattr__(moved, "__pydantic_extra__", None)
        object.__setattr__(moved, "__pydantic_private__", None)
        return moved

    def _require_fit(self) -> None:
        for fitting in FITTING_SECTIONS:
            self.require_fit(fitting)

    def require_fit(self, sections: tuple[str, ...]) -> None:
        """Check that the sections of one of ``FITTING_SECTIONS`` fit each other.

        Raises
        ------
        ValueError
            They do not.
        """
        if "fluid" in sections:
            require_fluid_fits(self.fluid, self.supply)
            return
        require_input_fits(self.input, self.control, self.run)
        require_load_fits(self.load, self.run)
        require_record_fits(self.n_kept - self.wavelet.latest_start, self.wavelet)
        require_jitter_fits(self.measurement, self.run)

    @property
    def is_periodic(self) -> bool:
        """Whether all that acts on the actuator repeats itself with the period of the input."""
        return self.input.is_periodic and not self.load.random_force

    @property
    def n_discarded(self) -> int:
        """Number of samples that the features leave out."""
        return round(self.run.discarded_time(self.input.period) * self.run.sampling_frequency)

    @property
    def n_kept(self) -> int:
        """Number of samples that the features are taken from."""
        return self.run.n_sample - self.n_discarded

    def with_ideal_sensors(self) -> RunParameters:
        """These parameters with every signal shown as it is."""
        ideal = {name: kind() for name, kind in SENSING.items() if not self.__dict__[name].is_default}
        return self.with_valid_sections(ideal) if ideal else self

    def is_shown_exactly(self, sensor: str) -> bool:
        """Whether a sensor, named by its section, shows its signal as it is."""
        shared = self.measurement
        return shared.jitter == 0.0 and shared.anti_alias is None and bool(getattr(self, sensor).is_ideal)

    def text(self) -> str:
        """What differs from the defaults, as JSON; keys sorted, floats in their shortest exact form.

        So a parameter that is added later leaves the identity of stored runs alone. A default that changes
        has to raise ``PHYSICS_VERSION``.
        """
        return sections_text(self.__dict__)

    @property
    def record_text(self) -> str:
        """`text` of all that the signals depend on; how they are analysed is left out."""
        analysis: dict[str, Section] = {"wavelet": WaveletConfig(), "run": self.run.without_discard}
        return sections_text(self.__dict__ | analysis)

    def value(self, name: str) -> Any:
        """The value of a dotted name, e.g. ``"fluid.bulk_modulus"``."""
        section, field = name.split(".")
        return getattr(getattr(self, section), field)

    def shown_sections(self) -> dict[str, dict[str, Any]]:
        """All parameters by section, as results show them."""
        sections: dict[str, dict[str, Any]] = {}
        for name in parameter_names():
            section, field = name.split(".")
            sections.setdefault(section, {})[field] = self.shown_value(name)
        return sections

    def shown_value(self, name: str) -> Any:
        """The value of a dotted name as results show it: a file by its name, size and digest."""
        return without_contents(self.value(name))


SORTED_SECTIONS = tuple(sorted(RunParameters.model_fields))
"""The sections in the order of a request."""

_ALL_SECTIONS = set(RunParameters.model_fields)

FITTING_SECTIONS = (
    ("fluid", "supply"),
    ("input", "control", "load", "run", "wavelet", "measurement"),
)
"""Sections that have to fit each other; in what else they hold, they are free."""

SENSING: dict[str, type[Section]] = {
    name: info.annotation
    for name, info in RunParameters.model_fields.items()
    if isinstance(info.annotation, type) and issubclass(info.annotation, SensorConfig | MeasurementConfig)
}
"""Sections that say how signals are measured, not what happens."""


def sections_text(sections: Mapping[str, Section]) -> str:
    """What differs from the defaults in sections, as JSON."""
    parts = [section_text(name, sections[name]) for name in SORTED_SECTIONS]
    return "{" + ",".join(filter(None, parts)) + "}"


def section_text(name: str, section: Section) -> str:
    """A section's part of a request; empty where it has its defaults."""
    return "" if section.is_default else f'"{name}":{section.stated_text}'


def parameter_names() -> Iterator[str]:
    """The dotted names of all parameters of a run."""
    for section, info in RunParameters.model_fields.items():
        assert isinstance(info.annotation, type)
        for field in info.annotation.model_fields:
            yield f"{section}.{field}"


def validate_parameter(name: str, value: Any) -> Any:
    """A value for a dotted name, in SI, checked on its own.

    Raises
    ------
    pydantic.ValidationError
        The value is not one that the parameter can take.
    """
    return _adapter(name).validate_python(value)


def parameter_unit(name: str) -> str | None:
    """SI unit of a dotted name; None for what is no quantity."""
    quantity = parameter_quantity(name)
    return None if quantity is None else quantity.unit


def parameter_quantity(name: str) -> SI | None:
    """Unit and limits of a dotted name; None for what is no quantity."""
    return next((part for part in _flattened_metadata(_field(name)) if isinstance(part, SI)), None)


def _flattened_metadata(field: FieldInfo) -> list[Any]:
    nested = [getattr(part, "__metadata__", ()) for part in getattr(field.annotation, "__args__", ())]
    return [*field.metadata, *(item for metadata in nested for item in metadata)]


def _field(name: str) -> FieldInfo:
    section, field = name.split(".")
    annotation: Any = RunParameters.model_fields[section].annotation
    info: FieldInfo = annotation.model_fields[field]
    return info


@lru_cache(maxsize=128)
def _adapter(name: str) -> TypeAdapter[Any]:
    field = _field(name)
    annotation: Any = field.annotation
    return TypeAdapter(Annotated[annotation, *field.metadata] if field.metadata else annotation)


def replace_fields(section: Section, fields: tuple[tuple[str, Any], ...]) -> Section:
    """A section with fields replaced; either form of the internal leakage replaces the other.

    Raises
    ------
    pydantic.ValidationError
        They are invalid, or do not fit the others.
    """
    new, kind = dict(fields), type(section)
    values = {name: section.__dict__[name] for name in kind.model_fields}
    if isinstance(section, LeakageConfig) and new.keys() & {"internal_coefficient", "internal_flow"}:
        values |= {"internal_coefficient": None, "internal_flow": None}
    replaced = kind.model_validate(values | new)
    object.__setattr__(replaced, "__pydantic_fields_set__", _all_fields(kind))  # one set for all of them
    return replaced


@lru_cache(maxsize=128)
def _all_fields(kind: type[Section]) -> set[str]:
    return set(kind.model_fields)
