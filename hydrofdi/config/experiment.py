"""The experiment file as a whole."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, WithJsonSchema, field_validator, model_validator

from hydrofdi.config.machine import FluidConfig
from hydrofdi.config.plant import absent_signals
from hydrofdi.config.request import OBSERVATION, RunRequest, parameter_names, parameter_unit
from hydrofdi.config.study import DetectionConfig, StudyConfig
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.faults import CHANNELS, OUTPUTS, AbsentIndicator
from hydrofdi.indicators.nominal_actuator import from_sheet
from hydrofdi.indicators.registry import FROM_FILES, load_plugin, sound_indicator, sources_in
from hydrofdi.indicators.selection import make_chosen
from hydrofdi.records.data_sheet import PLANT_PARAMETERS
from hydrofdi.settings.files import Source
from hydrofdi.settings.messages import first_reason, nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.transforms import WaveletConfig
from hydrofdi.units import parse_quantity, parse_unit

Indicators = Mapping[str, Indicator[Any]]
"""Label → indicator."""

DWT = "dwt"
"""Label of the indicator of the paper. Its options are the section ``wavelet``."""


@dataclass(frozen=True)
class IndicatorChoice:
    """Label → options of each indicator, as canonical JSON; `DWT` has the wavelet of a row.

    `stored_identity` stands for the identity of indicators that are not installed.
    """

    text: str = json.dumps({DWT: {}})
    stored_identity: str = ""

    def made(self, wavelet: WaveletConfig) -> Indicators:
        """Label → indicator, for the wavelet of a row."""
        return _made(self.text, wavelet, len(FROM_FILES))

    @property
    def absent(self) -> dict[str, str]:
        """Labels of indicators that are not installed, and why; they are only found in stored experiments."""
        made = self.made(PAPER).items()
        return {label: each.reason for label, each in made if isinstance(each, AbsentIndicator)}

    def placeholders(self, attributes: Mapping[str, Mapping[str, Any]]) -> dict[str, AbsentIndicator]:
        """Those that are not installed, with what a file says of each (`stored_attributes`)."""
        return {label: AbsentIndicator(why, attributes.get(label)) for label, why in self.absent.items()}

    @property
    def identity(self) -> str:
        """Name, version and options of each indicator; empty if they are the default."""
        return self.stored_identity or _identity(self.text)

    def __reduce__(self) -> tuple[Any, ...]:
        """With the content of its plug-ins, which another process then executes."""
        return _choice, (self.text, sources_in(self.text))


def _choice(text: str, sources: list[tuple[str, bytes]]) -> IndicatorChoice:
    for source in sources:
        load_plugin(*source)
    return IndicatorChoice(text)


@lru_cache(maxsize=1024)
def _made(text: str, wavelet: WaveletConfig, n_from_files: int) -> Indicators:
    options = json.loads(text)
    if DWT in options:
        options[DWT] = wavelet.stated()
    return {label: _installed(label, given) for label, given in options.items()}


def _installed(label: str, options: Mapping[str, Any]) -> Indicator[Any]:
    """An indicator, or a placeholder for one that is not installed."""
    own = dict(options)
    try:
        return sound_indicator(str(own.pop("kind", label)), own)
    except ValueError as error:
        return AbsentIndicator(first_reason(error))


@lru_cache(maxsize=1024)
def _identity(text: str) -> str:
    made = IndicatorChoice(text).made(PAPER)
    for each in made.values():
        if isinstance(each, AbsentIndicator):
            raise ConfigError(f"{each.reason}; install the package that adds it, or give the experiment file")
    shown = {label: [made[label].name, made[label].version, made[label].options.stated()] for label in made}
    return "" if shown == {DWT: [DWT, 1, {}]} else json.dumps(shown, separators=(",", ":"))


def stored_attributes(indicator: Indicator[Any]) -> dict[str, Any]:
    """What files say of an indicator, for readers that do not have it."""
    channels = {kind: " ".join(sorted(getattr(indicator, kind))) for kind in CHANNELS}
    return {
        "indicator": indicator.name,
        "version": indicator.version,
        "options": indicator.options.model_dump_json(),
        **channels,
        "outputs": OUTPUTS.dump_json(tuple(indicator.outputs)).decode(),
    }


PAPER = WaveletConfig()
"""The transform of the paper."""

DEFAULT_CHOICE = IndicatorChoice()


@dataclass(frozen=True)
class Analysis:
    """What is measured of one record, after its first `n_discarded` samples."""

    n_discarded: int = 0
    wavelet: WaveletConfig = PAPER
    choice: IndicatorChoice = DEFAULT_CHOICE

    @property
    def indicators(self) -> Indicators:
        """Label → indicator."""
        return self.choice.made(self.wavelet)

    def identities(self, record_id: str) -> dict[str, str]:
        """Label → hash of record, indicator, version, options and discarded samples."""
        return {
            label: hashlib.sha256(
                f"{record_id}\n{own.name}\n{own.version}\n{self.n_discarded}\n{own.options.stated_text}".encode()
            ).hexdigest()[:16]
            for label, own in self.indicators.items()
        }


DEFAULT_ANALYSIS = Analysis()


class CalibrationConfig(Section):
    """How K_i is solved from ``leakage.internal_flow``."""

    at: Literal["run", "nominal"] = "run"
    """Actuator for which K_i is solved, under the baseline's conditions. ``run``: each run's own, except for
    what the baseline sets. ``nominal``: the experiment's nominal one, in each scenario of an ensemble; K_i is
    then solved once per leakage flow and does not depend on other drawn or swept parameters."""


Paper = Literal["maddahi2015"]
"""A paper whose study hydrofdi knows: a package in `hydrofdi.papers`."""

ClaimId = Literal["C1", "C2", "C3", "C4", "C5", "C6"]
"""Identity of a claim, as in docs/report.md."""


class LimitsConfig(Section):
    """Limits that end a run when exceeded."""

    time_per_job: Annotated[float, SI("s", above=0)] | None = None
    """Wall time allowed for one run [s]; a run that takes longer is stored with status ``timeout``."""


SIGNALS = {
    "input_voltage": ("V", "valve input voltage u"),
    "reference_position": ("m", "position reference of the controller"),
    "load_force": ("N", "load force against positive motion, F_L"),
    "spool_position": ("m", "valve spool position x_v"),
    "piston_position": ("m", "piston position x_p"),
    "piston_velocity": ("m/s", "piston velocity v_p"),
    "chamber_1_pressure": ("Pa", "pressure of chamber 1, P_1"),
    "chamber_2_pressure": ("Pa", "pressure of chamber 2, P_2"),
    "valve_supply_pressure": ("Pa", "supply pressure at the valve, P_s"),
    "oil_temperature": ("K", "temperature of the oil"),
    "internal_leakage_flow": ("m^3/s", "leakage flow from chamber 1 to 2, q_il"),
}
"""Signal of a run → its unit and long name, in the order of a file."""

NAMED = {"all": (*SIGNALS,), "pressures": ("chamber_1_pressure", "chamber_2_pressure"), "none": ()}
"""Word for some of them → their names."""


def _as_text(given: Any) -> str:
    """A choice of signals as one text: a word for them, or their names in order."""
    names = NAMED.get(given, given.split(",")) if isinstance(given, str) else given
    is_list = isinstance(names, list | tuple)
    unknown = [name for name in names if name not in SIGNALS] if is_list else []
    if not is_list or (unknown and isinstance(given, str)):
        raise ValueError(f"must be 'all', 'pressures', 'none' or a list of signals; found {given!r}")
    if unknown:
        raise ValueError(f"there is no signal {unknown[0]!r}{nearest(str(unknown[0]), [*SIGNALS])}")
    kept = tuple(name for name in SIGNALS if name in names)
    return next((word for word, meant in NAMED.items() if meant == kept), ",".join(kept))


Signals = Annotated[
    str,
    BeforeValidator(_as_text),
    WithJsonSchema({"anyOf": [{"enum": list(NAMED)}, {"type": "array", "items": {"enum": list(SIGNALS)}}]}),
]
"""Which signals: ``all``, ``pressures``, ``none``, or names with commas between them."""


class StoreConfig(Section):
    """Content of the experiment file besides the features."""

    signals: Signals = "all"
    """``all`` signals, the chamber ``pressures`` alone, ``none``, or a list of signals to store, such as
    ``[chamber_1_pressure, spool_position]``: input_voltage, reference_position, load_force, spool_position,
    piston_position, piston_velocity, chamber_1_pressure, chamber_2_pressure, valve_supply_pressure,
    oil_temperature (if ``fluid.temperature`` is stated), internal_leakage_flow. A study stores none by
    default, but ``simulate --out`` stores all of its one run."""

    compression: Literal["none", "lzf", "gzip"] = "none"
    """Compression of the signals."""

    dtype: Literal["float32", "float64"] = "float64"
    """Precision of the stored signals; features are always computed and stored in double precision."""


Plugins = Annotated[
    Mapping[str, str], WithJsonSchema({"type": ["string", "array"], "items": {"type": "string"}})
]
"""Path → SHA-256; a path or a list of paths in a file."""

INTERNAL_LEAKAGE_FORMS = ("leakage.internal_coefficient", "leakage.internal_flow")
"""The two ways to state the internal leakage; one replaces the other."""


def data_sheet_of(sections: Mapping[str, Any]) -> dict[str, Any]:
    """Constant that indicators may need → its value in the sections of a nominal plant that have it.

    Beside an FMU, only those that the sections state.
    """
    fields = ((name, *parameter.split(".")) for name, parameter in PLANT_PARAMETERS.items())
    is_foreign = getattr(sections.get("plant"), "fmu", None) is not None
    values = (
        (name, getattr(sections.get(section), field, None))
        for name, section, field in fields
        if not is_foreign or field in getattr(sections.get(section), "model_fields_set", ())
    )
    return {"position_zero": "centre"} | {name: value for name, value in values if value is not None}


STORED = "stored"
"""Context of the validation of a stored experiment, whose indicators need not be installed."""

_GONE = {
    "replicates": {"count": 0, "seed": 0, "over": {}},
    "sample.correlation": None,
    "population.correlation": None,
    "population.method": "random",
    "input.end_frequency": 20.0,
    "input.harmonics": 20,
    "leakage.onset_duty": 0.5,
    "fluid.cavitation": "none",
    "reference": {"source": "", "tolerance": 0.5, "cells": []},
}
"""Key of earlier versions, below the last one above it → its default."""


def _without_gone(given: Any, above: str = "") -> Any:
    if isinstance(given, list):
        return [_without_gone(part, above) for part in given]
    if not isinstance(given, dict):
        return given
    named = ((f"{above}.{key}".lstrip("."), key, value) for key, value in given.items())
    kept = ((key, value) for name, key, value in named if _GONE.get(name, ...) != value)
    return {key: _without_gone(value, key) for key, value in kept}


class ExperimentConfig(RunRequest):
    """A nominal actuator, the parameters that vary, and the healthy state to compare with."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")] = "nominal"
    """Name of the experiment and of its folder below ``results/``."""

    plugins: Plugins = Field(default_factory=dict)
    """Python files with indicators of your own: a path, or a list of paths, relative to the file that names
    them. They are executed."""

    indicators: dict[str, Any] = Field(default_factory=lambda: {DWT: {}})
    """Indicators that are measured of every record (``hydrofdi indicators``): ``all``, a name, a list of
    names, or ``label: {options}``, where the option ``kind`` names the indicator if the label does not. The
    options of ``dwt`` itself are the section ``wavelet``, which may vary in a sweep. Constants of the plant
    that the options leave out are the nominal ones of the experiment."""

    baseline: dict[str, Any] = Field(default_factory=dict, validate_default=True)
    """Dotted parameters that, put into a run, make it the healthy run that δ compares with. The internal
    leakage flow is solved for K_i under the same conditions. What is left out: ``fluid.bulk_modulus`` is that
    of the experiment itself, and the piston is sealed."""

    calibration: CalibrationConfig = CalibrationConfig()
    """Which actuator a leakage flow is turned into K_i for."""

    sweep: SweepConfig = SweepConfig()
    """What varies."""

    store: StoreConfig = StoreConfig()
    """What is kept."""

    units: dict[str, str] = Field(default_factory=dict)
    """Dotted parameter → the unit in which plans and reports show it. A value that is written with a unit
    sets it: a bulk modulus of ``8000 bar`` is shown in bar. Leakage is shown in L/min."""

    limits: LimitsConfig = LimitsConfig()
    """Limits of a run."""

    ensemble: SweepConfig = SweepConfig()
    """Scenarios: what is not known for certain. The sweep is run in every scenario."""

    study: StudyConfig | None = None
    """Populations of healthy and leaking actuators. The points of ``sweep`` are then designs: each repeats
    the whole study with the same draws. Its runs have no baselines. K_i is solved once for each level at the
    nominal actuator, and no signals are stored, unless ``calibration.at`` and ``store.signals`` say so."""

    detection: DetectionConfig = DetectionConfig()
    """How indicators are judged as detectors, in a study."""

    paper: Paper | None = None
    """The paper whose study this is: its report then has the paper's tables, claims and figures."""

    claims: tuple[ClaimId, ...] = ()
    """Sentences of the paper that ``hydrofdi report --check`` requires to hold; needs ``paper``."""

    @model_validator(mode="before")
    @classmethod
    def _without_gone_keys(cls, given: Any, info: ValidationInfo) -> Any:
        """What earlier versions stored by default under keys that are gone."""
        return _without_gone(given) if info.context == STORED else given

    @field_validator("indicators")
    @classmethod
    def _known_indicators(cls, given: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        """The indicators with their options, and what these do not state of the plant, unless by default.

        They are checked by making them; stored ones are as they are.
        """
        chosen = {str(label): dict(options or {}) for label, options in given.items()}
        if info.context == STORED:
            return chosen
        sheet = data_sheet_of(info.data)
        try:
            for label, made in make_chosen(chosen, Source(chosen)).items():
                taken = from_sheet(made.options, sheet)
                chosen[label] |= {
                    name: value for name, value in taken.items() if value != getattr(made.options, name)
                }
            make_chosen(chosen, Source(chosen))
        except ConfigError as error:
            raise ValueError("; ".join(str(mistake) for mistake in error.mistakes)) from None
        return chosen

    @field_validator("units")
    @classmethod
    def _known_units(cls, given: dict[str, str]) -> dict[str, str]:
        """Units that fit the parameters."""
        for name, unit in given.items():
            own = parameter_unit(name) if name in parameter_names() else None
            if own is None:
                raise ValueError(f"{name}: is not a parameter with a unit")
            if name == "leakage.internal_flow" and parse_unit(unit) != parse_unit("L/min"):
                raise ValueError(f"{name}: is always shown in L/min")
            parse_quantity(f"1 {unit}", own)
        return given

    @field_validator("claims")
    @classmethod
    def _belong_to_a_paper(cls, given: tuple[ClaimId, ...], info: ValidationInfo) -> tuple[ClaimId, ...]:
        """Claims as given; a stored experiment may have them without its paper."""
        if given and info.context != STORED and info.data.get("paper", "mistaken") is None:
            raise ValueError("belong to a paper: add 'paper: maddahi2015', or leave claims out")
        if given and info.data.get("study"):
            raise ValueError("a study has no claims; those of the paper are about its own experiment")
        return given

    @field_validator("baseline")
    @classmethod
    def _healthy_actuator(cls, given: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        """The baseline as given, with the experiment's own EBM and a sealed piston for what it leaves out."""
        fluid = info.data.get("fluid")  # lacks where it is mistaken itself
        healthy = {"fluid.bulk_modulus": fluid.bulk_modulus} if isinstance(fluid, FluidConfig) else {}
        sealed = {} if given.keys() & set(INTERNAL_LEAKAGE_FORMS) else {"leakage.internal_flow": 0.0}
        return healthy | sealed | given

    @model_validator(mode="after")
    def _each_parameter_varies_once(self) -> Self:
        for pair in (("ensemble", "sweep"), ("sweep", "study")):
            one, other = (set(part.names if (part := getattr(self, name)) else ()) for name in pair)
            if twice := one & other:
                raise ValueError(f"{min(twice)} varies in both {' and '.join(pair)}")
        return self

    @model_validator(mode="after")
    def _what_varies_acts_on_the_plant(self) -> Self:
        plant = self.plant
        if plant.fmu is not None:
            acting = {"plant", "input", "control", "record", *OBSERVATION}
            acting |= {"load"} if "load_force" in plant.inputs else set()
            for name in self.varied_names:
                is_acting = name.partition(".")[0] in acting or name in INTERNAL_LEAKAGE_FORMS
                if not is_acting and name not in plant.parameters:
                    raise ValueError(
                        f"{name} does not act on {plant.name}: vary a parameter of the FMU, plant.…, or name"
                        f" the one that it sets: plant.parameters: {{{name}: …}}"
                    )
        return self

    @model_validator(mode="after")
    def _a_study_stands_alone(self) -> Self:
        if self.study is None:
            if self.detection != DetectionConfig():
                raise ValueError("detection needs the populations of a study; add study")
            return self
        if self.ensemble.names:
            raise ValueError("a study has no ensemble: put uncertain parameters into its population")
        return self

    @property
    def varied_names(self) -> list[str]:
        """Dotted parameters that differ between its runs."""
        in_study = self.study.names if self.study else []
        return list(dict.fromkeys([*self.ensemble.names, *self.sweep.names, *in_study]))

    @property
    def absent_signals(self) -> frozenset[str]:
        """Signals that its runs do not have: the oil temperature, if it is not stated."""
        if self.plant.fmu is not None:
            return absent_signals(self.plant)
        is_stated = self.fluid.temperature is not None or "fluid.temperature" in self.varied_names
        return frozenset() if is_stated else frozenset({"oil_temperature"})

    @property
    def has_scenarios(self) -> bool:
        """Whether the experiment is an ensemble; a run that is impossible is recorded, not rejected."""
        return bool(self.ensemble.names)

    @cached_property
    def nominal_parameters(self) -> RunRequest:
        """The parameters that all runs start from."""
        return RunRequest.model_construct(**{name: getattr(self, name) for name in RunRequest.model_fields})

    @property
    def data_sheet(self) -> dict[str, Any]:
        """Constant that indicators may need → its nominal value, whatever is drawn or swept."""
        return data_sheet_of(self.__dict__)

    @cached_property
    def indicator_choice(self) -> IndicatorChoice:
        """What is measured of every record."""
        return IndicatorChoice(json.dumps(self.indicators))
