"""The ``study`` section: populations of healthy and leaking actuators."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, WithJsonSchema, model_validator

from hydrofdi.config.sweeps.sample import CorrelationConfig, Distribution
from hydrofdi.config.sweeps.sweep import Axes
from hydrofdi.settings.mistakes import nearest
from hydrofdi.settings.quantities import Section

Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
FitCount = Annotated[int, Field(strict=True, ge=0, le=1_000_000)]

_VALUE_OR_DISTRIBUTION = {"type": ["number", "string", "boolean", "object"]}

Changes = Annotated[
    dict[str, Any], WithJsonSchema({"type": "object", "additionalProperties": _VALUE_OR_DISTRIBUTION})
]
"""Dotted parameter → its value in SI, or its distribution."""

SEAL = "leakage.internal_"
"""How the parameters begin that ``faults`` sets."""


class PopulationConfig(Section):
    """What varies from actuator to actuator, and from record to record, without a fault."""

    method: Literal["random", "sobol", "lhs"] = "random"
    """``random``: independent draws. Points of a Sobol sequence or a Latin hypercube depend on each other:
    binomial limits of rates do not hold for them, and the report says so."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of all draws of the study."""

    over: dict[str, Distribution] = Field(default_factory=dict)
    """Dotted parameter → its distribution, as in ``sample``: what differs from actuator to actuator."""

    per_record: dict[str, Distribution] = Field(default_factory=dict)
    """What differs from record to record on one actuator: drawn anew for each, also with ``pairing: common``.
    Unless the file names them, these are drawn: ``measurement.seed``; ``wavelet.phase``, where ``dwt`` is
    measured; ``input.seed``, where the input is pseudo-random; ``load.seed``, where the force is."""

    correlation: CorrelationConfig | None = None
    """Parameters of ``over`` that are drawn together; without it, all are independent."""

    @model_validator(mode="after")
    def _parameters_are_drawn_once(self) -> Self:
        if twice := sorted(self.over.keys() & self.per_record.keys()):
            raise ValueError(f"{twice[0]} is drawn under both over and per_record")
        for name in self.correlation.parameters if self.correlation else ():
            if name not in self.over:
                raise ValueError(f"correlation: {name!r} is not drawn{nearest(name, list(self.over))}")
        return self


class HealthyConfig(Section):
    """Numbers of records without a leak across the seal."""

    fit: Count
    """Records that thresholds and models are fitted to; they are never tested."""

    test: Count
    """Records that show how often a false alarm comes."""

    shift: Count | None = None
    """Records of each shift; without it, as many as ``test``."""

    confusion: Count | None = None
    """Records of each confusion; without it, as many as ``test``."""


class FaultsConfig(Section):
    """Leaks that are to be found.

    ``leakage.internal_flow: [0.1 L/min, …]`` is short for ``over: {leakage.internal_flow: …}``.
    """

    over: Axes = Field(min_length=1, max_length=1)
    """``leakage.internal_flow`` or ``leakage.internal_coefficient`` → levels, in all forms of an axis."""

    each: Count
    """Test records of each level."""

    fit: FitCount = 50
    """Further records of each level, from which directions and supervised scores are learned; they are never
    tested. 0: directions are those that indicators state, or both."""

    severity: Literal["record", "level"] = "record"
    """How severe a leak is. ``record``: the mean leakage flow of its own record (K_i, where levels are given
    by it). ``level``: its level, under the conditions of ``calibration`` and ``baseline``; for motions in
    which the same seal hardly leaks, such as a rest test."""

    @property
    def parameter(self) -> str:
        """Dotted name of what varies."""
        return next(iter(self.over))

    @property
    def levels(self) -> list[float]:
        """Its values in SI, ascending."""
        return sorted(self.over[self.parameter])

    @model_validator(mode="after")
    def _leaks_across_the_seal(self) -> Self:
        if not self.parameter.startswith(SEAL):
            raise ValueError(
                "faults are leaks: leakage.internal_flow or leakage.internal_coefficient,"
                f" not {self.parameter}"
            )
        if any(level == 0.0 for level in self.levels):
            raise ValueError("a leak of 0 is no fault; healthy.test records say how often it raises an alarm")
        return self


class SensitivityConfig(Section):
    """Further healthy records that show which parameter of ``population.over`` moves which score.

    Nothing is judged by them, and thresholds do not see them.
    """

    alone: FitCount = 0
    """Records in which one parameter varies and the others keep their values, for each parameter, and as many
    in which none varies; 0 or 49 and more. What differs from record to record differs in all of them."""

    sobol: FitCount = 0
    """Base points of a design for Sobol indices, a power of two from 16 on; 0: none. With d parameters it
    takes (d + 3) times as many records: Saltelli et al., Computer Physics Communications 181 (2010) 259, and
    once more for the noise."""

    @model_validator(mode="after")
    def _counts_carry_what_is_stated(self) -> Self:
        if 0 < self.alone < 49:
            raise ValueError(f"alone: a range of scores needs 49 records or more, not {self.alone}")
        if self.sobol and (self.sobol < 16 or self.sobol & (self.sobol - 1)):
            raise ValueError(f"sobol: give a power of two from 16 on, not {self.sobol}")
        return self


class StudyConfig(Section):
    """Populations of records: healthy ones, leaking ones, and healthy ones that thresholds never saw."""

    population: PopulationConfig = PopulationConfig()
    """What varies without a fault."""

    healthy: HealthyConfig
    """Records of actuators that do not leak across the seal."""

    faults: FaultsConfig | None = None
    """Leaks that are to be found; without it, false alarms alone are judged."""

    shifts: dict[str, Changes] = Field(default_factory=dict)
    """Name → what is set, or drawn otherwise, in healthy actuators that no threshold saw: other operating
    conditions."""

    confusions: dict[str, Changes] = Field(default_factory=dict)
    """Name → the same for other faults than an internal leak."""

    sensitivity: SensitivityConfig = SensitivityConfig()
    """Which of what varies without a fault moves which score."""

    pairing: Literal["independent", "common"] = "independent"
    """``independent``: each record has an actuator of its own. ``common``: the same actuators healthy, with
    each leak, shift and confusion, in the fit and in the test records apart. A healthy record of each is
    taken before, and the change of every score since then is judged beside it; what differs from record to
    record is drawn anew."""

    @property
    def names(self) -> list[str]:
        """Dotted parameters that differ between its records."""
        population, faults = self.population, self.faults.over if self.faults else {}
        others = (
            name for changes in (self.shifts, self.confusions) for each in changes.values() for name in each
        )
        return list(dict.fromkeys([*faults, *population.over, *population.per_record, *others]))

    @model_validator(mode="after")
    def _seals_are_those_of_faults(self) -> Self:
        healthy = {
            "population.over": self.population.over,
            "population.per_record": self.population.per_record,
        }
        for kind, named in (("shifts", self.shifts), ("confusions", self.confusions)):
            healthy |= {f"{kind}.{name}": changes for name, changes in named.items()}
        for place, changes in healthy.items():
            for name in changes:
                if name.startswith(SEAL):
                    raise ValueError(
                        f"{place}: {name} belongs under faults; these actuators do not leak there"
                    )
        if twice := sorted(self.shifts.keys() & self.confusions.keys()):
            raise ValueError(f"{twice[0]!r} is a shift and a confusion; give each a name of its own")
        return self

    @model_validator(mode="after")
    def _sensitivity_has_what_it_needs(self) -> Self:
        asked, population = self.sensitivity, self.population
        if (asked.alone or asked.sobol) and not population.over:
            raise ValueError("sensitivity: nothing varies; give population.over")
        if asked.sobol and population.correlation:
            raise ValueError(
                "sensitivity.sobol: Sobol indices are those of independent parameters;"
                " leave it out, or population.correlation"
            )
        return self
