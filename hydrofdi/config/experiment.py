"""The experiment file as a whole."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from hydrofdi.config.analysis import DWT, IndicatorChoice
from hydrofdi.config.calibration import CalibrationConfig
from hydrofdi.config.claims import ClaimId, Paper
from hydrofdi.config.limits import LimitsConfig
from hydrofdi.config.parameters import SENSING
from hydrofdi.config.reference import ReferenceConfig
from hydrofdi.config.request import RunRequest, parameter_names, parameter_unit
from hydrofdi.config.sections.fluid import FluidConfig
from hydrofdi.config.store import StoreConfig
from hydrofdi.config.study.detection import DetectionConfig
from hydrofdi.config.study.study import StudyConfig
from hydrofdi.config.sweeps.replicates import ReplicatesConfig
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.selection import make_chosen
from hydrofdi.settings.yaml_source import Source
from hydrofdi.units import parse_quantity, parse_unit

INTERNAL_LEAKAGE_FORMS = ("leakage.internal_coefficient", "leakage.internal_flow")
"""The two ways to state the internal leakage; one replaces the other."""

STORED = "stored"
"""Context of the validation of a stored experiment, whose indicators need not be installed."""

_NO_PAPER = "belong to a paper: add 'paper: maddahi2015', or leave {} out"


class ExperimentConfig(RunRequest):
    """A nominal actuator, the parameters that vary, and the healthy state to compare with."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")] = "nominal"
    """Name of the experiment and of its folder below ``results/``."""

    indicators: dict[str, Any] = Field(default_factory=lambda: {DWT: {}})
    """Indicators that are measured of every record (``hydrofdi indicators``): ``all``, a name, a list of
    names, or ``label: {options}``, where the option ``kind`` names the indicator if the label does not. The
    options of ``dwt`` itself are the section ``wavelet``, which may vary in a sweep."""

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

    replicates: ReplicatesConfig = ReplicatesConfig()
    """Replicates: healthy actuators with normal variation."""

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

    reference: ReferenceConfig = ReferenceConfig()
    """Published values to compare with; needs ``paper``."""

    @field_validator("indicators")
    @classmethod
    def _known_indicators(cls, given: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        """The indicators with their options, which are checked by making them; stored ones as they are."""
        chosen = {str(label): dict(options or {}) for label, options in given.items()}
        if info.context == STORED:
            return chosen
        try:
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

    @field_validator("claims", "reference")
    @classmethod
    def _belong_to_a_paper(cls, given: Any, info: ValidationInfo) -> Any:
        """Claims and published values as given; a stored experiment may have them without its paper."""
        is_listed = bool(given.cells if isinstance(given, ReferenceConfig) else given)
        if is_listed and info.context != STORED and info.data.get("paper", "mistaken") is None:
            raise ValueError(_NO_PAPER.format(info.field_name))
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
    def _scenarios_leave_the_sweep_alone(self) -> Self:
        if twice := set(self.ensemble.names) & set(self.sweep.names):
            raise ValueError(f"{sorted(twice)[0]} varies in both ensemble and sweep")
        return self

    @model_validator(mode="after")
    def _replicates_differ(self) -> Self:
        if self.replicates.count == 1:
            raise ValueError("one replicate has no range; set replicates.count to 2 or more")
        if leaks := [name for name in self.replicates.over if name.startswith("leakage.")]:
            raise ValueError(f"replicates are healthy: {leaks[0]} does not belong under replicates.over")
        is_noisy = any(not self.is_shown_exactly(name) for name in SENSING if name != "measurement")
        if self.replicates.count and not self.replicates.over and not is_noisy:
            raise ValueError("all replicates would be equal; set replicates.over, or give sensors noise")
        return self

    @model_validator(mode="after")
    def _a_study_stands_alone(self) -> Self:
        if self.study is None:
            if self.detection != DetectionConfig():
                raise ValueError("detection needs the populations of a study; add study")
            return self
        if self.ensemble.names:
            raise ValueError("a study has no ensemble: put uncertain parameters into its population")
        if self.replicates.count:
            raise ValueError("a study has no replicates: each of its records is already one")
        if twice := set(self.sweep.names) & set(self.study.names):
            raise ValueError(f"{sorted(twice)[0]} varies in both sweep and study")
        return self

    @property
    def varied_names(self) -> list[str]:
        """Dotted parameters that differ between its runs."""
        in_study = self.study.names if self.study else []
        return list(dict.fromkeys([*self.ensemble.names, *self.sweep.names, *in_study]))

    @property
    def has_scenarios(self) -> bool:
        """Whether the experiment is an ensemble; a run that is impossible is recorded, not rejected."""
        return bool(self.ensemble.names)

    @cached_property
    def nominal_parameters(self) -> RunRequest:
        """The parameters that all runs start from."""
        return RunRequest.model_construct(**{name: getattr(self, name) for name in RunRequest.model_fields})

    @cached_property
    def indicator_choice(self) -> IndicatorChoice:
        """What is measured of every record."""
        return IndicatorChoice.of(self.indicators)
