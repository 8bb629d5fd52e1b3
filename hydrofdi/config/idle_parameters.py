"""Parameters of an option that is off: stated, but without effect."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.parameters import SENSING
from hydrofdi.config.plausibility import block_values
from hydrofdi.config.request import RunRequest, parameter_names
from hydrofdi.config.sections.sensor import SensorConfig
from hydrofdi.config.study.values import study_values
from hydrofdi.physics.friction import LIMITED_PARAMETERS, laws_that_use


@dataclass(frozen=True)
class _Needs:
    """The values of an option with which a parameter has an effect: some alone, or all but some."""

    option: str
    only: tuple[Any, ...] = ()
    but: tuple[Any, ...] = ()

    def are_met_by(self, value: Any) -> bool:
        return value in self.only if self.only else value not in self.but


_OPEN_LOOP = _Needs("control.law", only=("open",))
_CLOSED_LOOP = _Needs("control.law", but=("open",))
_NO_FILE = _Needs("input.shape", but=("csv",))
_FREE_AIR = _Needs("fluid.law", only=("free_air",))
_END_STOPS = _Needs("actuator.end_stops", only=("elastic",))
_DROOP = _Needs("supply.droop", only=("first_order",))
_ONSET = _Needs("leakage.onset", but=("constant",))
_RANDOM_FORCE = _Needs("load.random_force", but=(0.0,))

_NEEDS: dict[str, tuple[_Needs, ...]] = (
    {
        "actuator.end_stop_position": (_END_STOPS,),
        "actuator.end_stop_stiffness": (_END_STOPS,),
        "supply.droop_resistance": (_DROOP,),
        "supply.droop_time_constant": (_DROOP,),
        "fluid.free_air": (_FREE_AIR,),
        "fluid.polytropic_exponent": (_FREE_AIR,),
        "fluid.atmospheric_pressure": (_FREE_AIR,),
        "leakage.laminar_reference": (_Needs("leakage.law", only=("laminar",)),),
        "leakage.blending_pressure": (_Needs("leakage.law", only=("blended",)),),
        "leakage.onset_time": (_ONSET,),
        "leakage.onset_duration": (_Needs("leakage.onset", only=("ramp", "intermittent")),),
        "leakage.onset_duty": (_Needs("leakage.onset", only=("intermittent",)),),
        "input.amplitude": (_OPEN_LOOP, _NO_FILE),
        "input.period": (_NO_FILE,),
        "input.end_frequency": (_Needs("input.shape", only=("sweep",)),),
        "input.harmonics": (_Needs("input.shape", only=("multisine",)),),
        "input.seed": (_Needs("input.shape", only=("steps",)),),
        "control.amplitude": (_CLOSED_LOOP, _NO_FILE),
        "control.proportional_gain": (_CLOSED_LOOP,),
        "control.integral_gain": (_Needs("control.law", only=("pi", "pid")),),
        "control.derivative_gain": (_Needs("control.law", only=("pid",)),),
        "control.sample_time": (_CLOSED_LOOP,),
        "control.feedback": (_CLOSED_LOOP,),
        "control.voltage_limit": (_CLOSED_LOOP,),
        "measurement.anti_alias_order": (_Needs("measurement.anti_alias", but=(None,)),),
        "load.random_period": (_RANDOM_FORCE,),
        "load.seed": (_RANDOM_FORCE,),
    }
    | {f"friction.{name}": (_Needs("friction.law", only=laws_that_use(name)),) for name in LIMITED_PARAMETERS}
    | {
        f"{section}.{name}": (_Needs(f"{section}.{option}", **values),)
        for section, info in RunRequest.model_fields.items()
        if isinstance(info.default, SensorConfig)
        for name, option, values in (
            ("damping_ratio", "order", {"only": ("second",)}),
            ("noise_bandwidth", "noise", {"but": (0.0,)}),
        )
    }
)
"""Parameter → what it needs for an effect, all of it; parameters that always have one are left out."""


def idle_parameters(experiment: ExperimentConfig) -> list[str]:
    """A sentence on each parameter that is stated, or varies, but has no effect in any run."""
    stated = _stated_parameters(experiment)
    return [
        sentence
        for name, needs in _NEEDS.items()
        if name in stated and (sentence := _sentence(name, needs, experiment))
    ]


def idle_draws(experiment: ExperimentConfig, names: Iterable[str]) -> set[str]:
    """Those of some parameters that have no effect in any run of a study, whatever they are."""
    needs = _NEEDS | ({} if _has_chance(experiment) else {"measurement.seed": ()})
    return {
        name
        for name in names
        if name in needs and (not needs[name] or _sentence(name, needs[name], experiment))
    }


def _has_chance(experiment: ExperimentConfig) -> bool:
    """Whether a sensor has noise, or the clock jitter, in any run."""
    noisy = {f"{section}.{field}" for section in SENSING for field in ("noise", "noise_density", "jitter")}
    chances = noisy & set(parameter_names())
    return any(value for name in chances for value in _occurring_values(name, experiment))


def _stated_parameters(experiment: ExperimentConfig) -> set[str]:
    """Parameters that differ from their defaults, or vary."""
    default = RunRequest()
    nominal = {name for name in parameter_names() if experiment.value(name) != default.value(name)}
    baseline = {name for name, value in experiment.baseline.items() if value != default.value(name)}
    return nominal | baseline | {*experiment.ensemble.names, *experiment.sweep.names}


def _sentence(name: str, needs: tuple[_Needs, ...], experiment: ExperimentConfig) -> str:
    for need in needs:
        values = list(dict.fromkeys(_occurring_values(need.option, experiment)))
        if not any(need.are_met_by(value) for value in values):
            choices = " or ".join(_shown(value) for value in values)
            return f"{name} has no effect: {need.option} is {choices} in every run"
    return ""


def _shown(value: Any) -> str:
    if value is None:
        return "null"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _occurring_values(option: str, experiment: ExperimentConfig) -> Iterator[Any]:
    """The values that an option may have in some run."""
    blocks = [experiment.ensemble, experiment.sweep]
    if not any(option in block.names_throughout for block in blocks):
        yield experiment.value(option)
    if option in experiment.baseline:
        yield experiment.baseline[option]
    for block in blocks:
        yield from (value for name, value in block_values(block) if name == option)
    if experiment.study is not None:
        yield from (value for name, value in study_values(experiment.study) if name == option)
