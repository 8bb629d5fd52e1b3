"""All that determines a row of a sweep, its record and its analysis, and access to it by names.

A parameter has a full name with a dot; its symbols, and its last part if it is unique, stand for that.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache, lru_cache
from itertools import chain
from typing import Annotated, Any, ClassVar, Self

from pydantic import TypeAdapter, model_validator
from pydantic.fields import FieldInfo

from hydrofdi.config import drive, machine, observation
from hydrofdi.config.observation import AnalysisConfig
from hydrofdi.config.plant import PlantConfig, foreign_quantity, foreign_value, is_foreign, require_plant_fits
from hydrofdi.physics.cylinder import pressure_force
from hydrofdi.physics.hydraulic_mode import rest_pressures
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI, Section, field_quantity
from hydrofdi.transforms import WaveletConfig


class RunParameters(Section):
    """The validated sections of one record, in SI."""

    actuator: machine.ActuatorConfig = machine.ActuatorConfig()
    """Cylinder and load."""
    supply: machine.SupplyConfig = machine.SupplyConfig()
    """Supply and return pressure."""
    fluid: machine.FluidConfig = machine.FluidConfig()
    """Fluid."""
    valve: machine.ValveConfig = machine.ValveConfig()
    """Servovalve."""
    supply_1_edge: machine.EdgeConfig = machine.EdgeConfig()
    """Edge of the valve from the supply to chamber 1."""
    return_1_edge: machine.EdgeConfig = machine.EdgeConfig()
    """Edge of the valve from chamber 1 to the return."""
    supply_2_edge: machine.EdgeConfig = machine.EdgeConfig()
    """Edge of the valve from the supply to chamber 2."""
    return_2_edge: machine.EdgeConfig = machine.EdgeConfig()
    """Edge of the valve from chamber 2 to the return."""
    friction: machine.FrictionConfig = machine.FrictionConfig()
    """Friction."""
    leakage: machine.LeakageConfig = machine.LeakageConfig()
    """Internal and external leakage."""
    input: drive.InputConfig = drive.InputConfig()
    """Drive voltage, or reference of a controller."""
    control: drive.ControlConfig = drive.ControlConfig()
    """Open loop, or position control."""
    load: machine.LoadConfig = machine.LoadConfig()
    """Force on the piston."""
    record: drive.RecordConfig = drive.RecordConfig()
    """Integration and sampling."""
    measurement: observation.MeasurementConfig = observation.MeasurementConfig()
    """Common settings of the sensors."""
    pressure_1_sensor: observation.PressureSensorConfig = observation.PressureSensorConfig()
    """Sensor of the chamber-1 pressure."""
    pressure_2_sensor: observation.PressureSensorConfig = observation.PressureSensorConfig()
    """Sensor of the chamber-2 pressure."""
    supply_sensor: observation.PressureSensorConfig = observation.PressureSensorConfig()
    """Sensor of the supply pressure."""
    position_sensor: observation.LengthSensorConfig = observation.LengthSensorConfig()
    """Sensor of the piston position."""
    velocity_sensor: observation.VelocitySensorConfig = observation.VelocitySensorConfig()
    """Sensor of the piston velocity."""
    spool_sensor: observation.LengthSensorConfig = observation.LengthSensorConfig()
    """Sensor of the spool position."""
    voltage_sensor: observation.VoltageSensorConfig = observation.VoltageSensorConfig()
    """Sensor of the input voltage."""
    temperature_sensor: observation.TemperatureSensorConfig = observation.TemperatureSensorConfig()
    """Sensor of the oil temperature; it acts if ``fluid.temperature`` is stated."""
    plant: PlantConfig = PlantConfig()
    """An FMU in the place of cylinder, valve and fluid."""

    fits: ClassVar[Mapping[tuple[str, ...], Callable[..., None]]] = {
        ("fluid", "supply"): machine.require_fluid_fits,
        ("input", "control", "record"): drive.require_input_fits,
        ("load", "record"): drive.require_load_fits,
        ("measurement", "record"): observation.require_jitter_fits,
        ("plant", "control", "leakage", "record"): require_plant_fits,
    }
    # sections that have to fit each other, and their check; in what else they hold, they are free

    @model_validator(mode="after")
    def _sections_fit_each_other(self) -> Self:
        return self._fitting(type(self).model_fields)

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """These parameters with dotted names replaced; either form of internal leakage replaces the other."""
        changed: dict[str, list[tuple[str, Any]]] = {}
        for name, value in values.items():
            section, _, field = name.partition(".")
            changed.setdefault(section, []).append((field, value))
        moved = self.with_valid_sections(
            {name: replace_fields(self.__dict__[name], tuple(fields)) for name, fields in changed.items()}
        )
        return moved._fitting(changed)

    def with_valid_sections(self, sections: Mapping[str, Section]) -> Self:
        """These parameters with sections replaced that are known to fit."""
        moved = type(self).__new__(type(self))
        object.__setattr__(moved, "__dict__", {**self.__dict__, **sections})
        object.__setattr__(moved, "__pydantic_fields_set__", _all_fields(type(self)))
        object.__setattr__(moved, "__pydantic_extra__", None)
        object.__setattr__(moved, "__pydantic_private__", None)
        return moved

    def _fitting(self, changed: Collection[str]) -> Self:
        """The same; a ValueError if a section that changed does not fit others."""
        for sections, require_fit in self.fits.items():
            if any(name in changed for name in sections):
                require_fit(*(self.__dict__[name] for name in sections))
        return self

    @property
    def is_periodic(self) -> bool:
        """Whether all that acts on the actuator repeats itself with the period of the input."""
        return self.input.is_periodic and not self.load.random_force

    @property
    def drive_period(self) -> float | None:
        """Period of all that acts on the actuator [s]; None if there is none."""
        return self.input.period if self.is_periodic else None

    @property
    def samples_per_period(self) -> int | None:
        """Samples of a period of all that acts on the actuator; None if there is none, or no whole number."""
        samples = self.input.period * self.record.sampling_frequency
        return round(samples) if self.is_periodic and drive.is_whole(samples) else None

    @property
    def held_force(self) -> float:
        """Constant force against extension that the pressures hold at rest [N]."""
        return self.actuator.weight + self.load.constant_force

    @property
    def mean_modulus(self) -> float:
        """β without air at the mean of supply and return pressure [Pa]."""
        return self.fluid.modulus_at(0.5 * (self.supply.pressure + self.supply.return_pressure))

    @property
    def start_pressures(self) -> tuple[float, float]:
        """P_1 and P_2 at the start [Pa]: in equilibrium with weight and constant load.

        With equal areas and a horizontal axis the mean of supply and return pressure for any load (paper).
        """
        supply, ret, actuator = self.supply.pressure, self.supply.return_pressure, self.actuator
        if actuator.area_2 == actuator.piston_area and actuator.inclination == 0.0:
            return 0.5 * (supply + ret), 0.5 * (supply + ret)
        return rest_pressures(supply, ret, *actuator.areas, self.held_force)

    @property
    def start_support(self) -> float:
        """Displacement of the support of the cylinder at the start, under the start pressures [m]."""
        if (stiffness := self.actuator.foundation_stiffness) is None:
            return 0.0
        held: float = pressure_force(*self.start_pressures, *self.actuator.areas)
        return (0.0 - held) / stiffness

    @property
    def edges(self) -> machine.Edges:
        """The metering edges of the valve."""
        valve, edges = self.valve, []
        for name in EDGES:
            own = self.__dict__[name]
            laps = valve.lap + own.lap, valve.lap_leakage + own.lap_leakage
            edges.append(machine.Edge(*laps, valve.flow_gain * own.flow_gain_ratio))
        return machine.Edges(*edges)

    @property
    def largest_opening_at_rest(self) -> float:
        """How far an edge stands open while the spool is at its zero, at most [m]."""
        valve, underlap = self.valve, max(0.0, *(-edge.lap for edge in self.edges))
        null = max(abs(valve.null_offset), abs(valve.null_offset + valve.null_drift * self.record.duration))
        return 0.5 * valve.edge_rounding + null + underlap

    @property
    def reads_at_valve(self) -> bool:
        """Whether the pressure sensors of the chambers are separated from these by hoses."""
        return self.measurement.pressures_at == "valve" and self.actuator.hose_volume > 0.0

    def is_shown_exactly(self, sensor: str) -> bool:
        """Whether a sensor, named by its section, shows its signal as it is."""
        shared = self.measurement
        if self.reads_at_valve and sensor in ("pressure_1_sensor", "pressure_2_sensor"):
            return False
        if sensor == "temperature_sensor" and self.fluid.temperature is None:
            return True
        return shared.jitter == 0.0 and shared.anti_alias is None and bool(getattr(self, sensor).is_ideal)

    def text(self) -> str:
        """What differs from the defaults, as JSON; a changed default has to raise ``PHYSICS_VERSION``."""
        return sections_text({name: self.__dict__[name] for name in RECORD_SECTIONS})

    def value(self, name: str) -> Any:
        """The value of a dotted name, e.g. ``"fluid.bulk_modulus"``."""
        section, _, field = name.partition(".")
        return self.plant.own.get(field) if is_foreign(name) else getattr(getattr(self, section), field)

    def shown_sections(self) -> dict[str, dict[str, Any]]:
        """All parameters by section, as results show them; that of an FMU if there is one."""
        return {
            name: {
                field: self.shown_value(f"{name}.{field}")
                for field in (*type(section).model_fields, *(section.model_extra or {}))
            }
            for name, section in ((name, self.__dict__[name]) for name in type(self).model_fields)
            if not (section.is_default and name in (OWN_PLANT if self.plant.fmu else ("plant",)))
        }

    def shown_value(self, name: str) -> Any:
        """The value of a dotted name as results show it: a file by its name, size and digest."""
        value = self.value(name)
        return value.stated() if isinstance(value, Section) else drive.without_contents(value)


OWN_PLANT = (
    "actuator", "supply", "fluid", "valve", "friction",
    "supply_1_edge", "return_1_edge", "supply_2_edge", "return_2_edge",
)  # fmt: skip
"""Sections that an FMU replaces; of one, they are constants that indicators may need."""

RECORD_SECTIONS = tuple(sorted(RunParameters.model_fields))
"""The sections that determine a record, in the order of its text."""

EDGES = ("supply_1_edge", "return_1_edge", "supply_2_edge", "return_2_edge")
"""Sections of the metering edges, in the order of `Edges`."""

SENSING: dict[str, type[Section]] = {
    name: info.annotation
    for name, info in RunParameters.model_fields.items()
    if isinstance(info.annotation, type)
    and issubclass(info.annotation, observation.SensorConfig | observation.MeasurementConfig)
}
"""Sections that say how signals are measured, not what happens."""


_SPELLED = {"record": "run"}
"""Section → its name in hashed texts: ``record`` was called ``run``, and identities and noise are kept."""


def sections_text(sections: Mapping[str, Section]) -> str:
    """What differs from the defaults in sections, as JSON."""
    parts = [section_text(name, sections[name]) for name in sorted(sections)]
    return "{" + ",".join(filter(None, parts)) + "}"


def section_text(name: str, section: Section) -> str:
    """A section's part of a text; empty if it has its defaults."""
    return "" if section.is_default else f'"{_SPELLED.get(name, name)}":{section.stated_text}'


def replace_fields(section: Section, fields: tuple[tuple[str, Any], ...]) -> Section:
    """A section with fields replaced; either form of the internal leakage replaces the other."""
    new, kind = dict(fields), type(section)
    values = {name: section.__dict__[name] for name in kind.model_fields} | (section.model_extra or {})
    if isinstance(section, machine.LeakageConfig) and new.keys() & {"internal_coefficient", "internal_flow"}:
        values |= {"internal_coefficient": None, "internal_flow": None}
    replaced = kind.model_validate(values | new)
    object.__setattr__(replaced, "__pydantic_fields_set__", _all_fields(kind))  # one set for all of them
    return replaced


@lru_cache(maxsize=128)
def _all_fields(kind: type[Section]) -> set[str]:
    return set(kind.model_fields)


class RunRequest(RunParameters):
    """The validated sections of one row, in SI: those of its record, and those of its analysis."""

    analysis: AnalysisConfig = AnalysisConfig()
    """What is analysed of a record."""
    wavelet: WaveletConfig = WaveletConfig()
    """Wavelet transform."""

    fits: ClassVar[Mapping[tuple[str, ...], Callable[..., None]]] = {
        **RunParameters.fits,
        ("analysis", "input", "record"): observation.require_discard_fits,
        ("record", "analysis", "input", "wavelet"): observation.require_record_fits,
    }

    @property
    def parameters(self) -> RunParameters:
        """Those of the record alone."""
        return RunParameters().with_valid_sections({name: self.__dict__[name] for name in RECORD_SECTIONS})

    @property
    def n_discarded(self) -> int:
        """Number of samples that the analysis leaves out."""
        return round(self.analysis.discarded_time(self.input.period) * self.record.sampling_frequency)

    @property
    def n_kept(self) -> int:
        """Number of samples that are analysed."""
        return self.record.n_sample - self.n_discarded

    def with_defaults(self, sections: Mapping[str, type[Section]]) -> RunRequest:
        """The same with some sections by default: `SENSING`, or all of `OBSERVATION`."""
        plain = {name: kind() for name, kind in sections.items() if not self.__dict__[name].is_default}
        return self.with_valid_sections(plain) if plain else self


ANALYSIS_SECTIONS = tuple(sorted(RunRequest.model_fields.keys() - RunParameters.model_fields.keys()))
"""The sections that say how a record is analysed."""

OBSERVATION: dict[str, type[Section]] = SENSING | {"analysis": AnalysisConfig, "wavelet": WaveletConfig}
"""Sections that say how signals are measured and analysed, not what happens."""


class _Names(tuple[str, ...]):
    """Dotted names, among which are those of any FMU."""

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or is_foreign(name)


@cache
def parameter_names(kind: type[RunParameters] = RunRequest) -> tuple[str, ...]:
    """The dotted names of all parameters of a run, or of a record alone."""
    sections = {name: info.annotation for name, info in kind.model_fields.items() if name != "plant"}
    return _Names(
        f"{name}.{field}"
        for name, section in sections.items()
        if isinstance(section, type) and issubclass(section, Section)
        for field in section.model_fields
    )


def validate_parameter(name: str, value: Any) -> Any:
    """A value for a dotted name, in SI, checked on its own."""
    if is_foreign(name):
        return foreign_value(name, value)
    return _adapter(name).validate_python(value)


def parameter_unit(name: str) -> str | None:
    """SI unit of a dotted name; None if it is not a quantity."""
    quantity = parameter_quantity(name)
    return None if quantity is None else quantity.unit


def parameter_quantity(name: str) -> SI | None:
    """Unit and limits of a dotted name; None if it is not a quantity."""
    if is_foreign(name):
        return foreign_quantity(name)
    return field_quantity(_field(name))


def _field(name: str) -> FieldInfo:
    section, field = name.split(".")
    annotation: Any = RunRequest.model_fields[section].annotation
    info: FieldInfo = annotation.model_fields[field]
    return info


@lru_cache(maxsize=128)
def _adapter(name: str) -> TypeAdapter[Any]:
    field = _field(name)
    annotation: Any = field.annotation
    return TypeAdapter(Annotated[annotation, *field.metadata] if field.metadata else annotation)


SYMBOLS = {
    name: tuple(quantity.symbols.split())
    for name in parameter_names()
    if (quantity := parameter_quantity(name)) and quantity.symbols
}
"""Full name → its symbols in equations and papers, the usual one first."""


def full_name(name: str) -> str:
    """The full name that a name, a symbol or a unique last part stands for; any other text as it is."""
    return full_names().get(name, name)


def short_name(full: str) -> str:
    """The first symbol of a parameter, else its last part if it is unique, else the full name."""
    last = full.partition(".")[2]
    return SYMBOLS[full][0] if full in SYMBOLS else last if full_name(last) == full else full


@cache
def full_names() -> dict[str, str]:
    """All that stands for a full name."""
    last = {full: full.partition(".")[2] for full in parameter_names()}
    count = Counter(last.values())
    unique = {part: full for full, part in last.items() if count[part] == 1 and part != "name"}
    spelt = {name.replace(".", "__"): name for name in parameter_names()}
    symbols = {symbol: full for full, own in SYMBOLS.items() for symbol in own}
    in_section = {f"{full.partition('.')[0]}.{symbol}": full for symbol, full in symbols.items()}
    return unique | spelt | in_section | symbols


def meant(name: str, known: Sequence[str] = ()) -> str:
    """The end of a message on a name of no parameter: those that it may stand for, other known ones first."""
    several = [full for full in parameter_names() if full.partition(".")[2] == name]
    if several:
        return f"; write {' or '.join(several[:3])}{' …' * (len(several) > 3)}"
    return nearest(name, [*known, *parameter_names(), *chain(*SYMBOLS.values())]) if len(name) > 1 else ""
