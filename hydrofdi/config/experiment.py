"""The experiment file as a whole."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from hydrofdi.config.claims import ClaimId
from hydrofdi.config.limits import LimitsConfig
from hydrofdi.config.parameters import RunParameters
from hydrofdi.config.reference import ReferenceConfig
from hydrofdi.config.store import StoreConfig
from hydrofdi.config.sweep import SweepConfig

NORMAL_CONDITIONS = {"fluid.bulk_modulus": 551e6, "leakage.internal_flow": 0.0}
"""The paper's normal operating mode: EBM of 551 MPa and a sealed piston."""

INTERNAL_LEAKAGE_FORMS = ("leakage.internal_coefficient", "leakage.internal_flow")
"""The two ways to state the internal leakage; one replaces the other."""


class ExperimentConfig(RunParameters):
    """A nominal actuator, the parameters that vary, and the healthy state to compare with."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")] = "nominal"
    """Name of the experiment and of its folder below ``results/``."""

    baseline: dict[str, Any] = Field(default_factory=lambda: dict(NORMAL_CONDITIONS))
    """Dotted parameters that, put into a run, make it the healthy run that δ compares with. The internal
    leakage flow is solved for K_i under the same conditions."""

    sweep: SweepConfig = SweepConfig()
    """What varies."""

    store: StoreConfig = StoreConfig()
    """What is kept."""

    limits: LimitsConfig = LimitsConfig()
    """What a run may use up."""

    ensemble: SweepConfig = SweepConfig()
    """Readings: what is not known for certain. The sweep is run in every reading."""

    claims: tuple[ClaimId, ...] = ()
    """Sentences of the paper that ``hydrofdi report --check`` requires to hold."""

    reference: ReferenceConfig = ReferenceConfig()
    """Published values to compare with."""

    @model_validator(mode="after")
    def _readings_leave_the_sweep_alone(self) -> Self:
        if twice := set(self.ensemble.names) & set(self.sweep.names):
            raise ValueError(f"{sorted(twice)[0]} varies in both ensemble and sweep")
        return self

    @property
    def has_readings(self) -> bool:
        """Whether the experiment is an ensemble; a run that is impossible is then a result, no mistake."""
        return bool(self.ensemble.names)

    @cached_property
    def nominal_parameters(self) -> RunParameters:
        """The parameters that all runs start from."""
        return RunParameters.model_construct(
            **{name: getattr(self, name) for name in RunParameters.model_fields}
        )


def complete_baseline(given: dict[str, Any]) -> dict[str, Any]:
    """The baseline as given, with normal conditions for what it leaves out."""
    normal = dict(NORMAL_CONDITIONS)
    if any(form in given for form in INTERNAL_LEAKAGE_FORMS):
        del normal["leakage.internal_flow"]
    return normal | given
