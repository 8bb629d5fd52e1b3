"""Values far from those of usual actuators: most often a missing unit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.request import SENSING, RunRequest, parameter_names, parameter_quantity
from hydrofdi.config.sections.csv_input import parse_rows
from hydrofdi.config.sections.sensor import SensorConfig
from hydrofdi.config.shown_values import shown_in, shown_value
from hydrofdi.config.study.study import study_values
from hydrofdi.config.sweeps.distributions import argument_values
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.physics.friction import LIMITED_PARAMETERS, laws_that_use
from hydrofdi.settings.counting import counted
from hydrofdi.settings.quantities import SI
from hydrofdi.units import parse_quantity


def unusual_values(experiment: ExperimentConfig, *, with_sweep: bool = True) -> list[str]:
    """A sentence on each parameter of which some value is far from the usual ones.

    Parameters
    ----------
    experiment : ExperimentConfig
    with_sweep : bool
        Whether values of ``sweep`` and ``ensemble`` count; without them, the nominal run is looked at.
    """
    values: dict[str, dict[Any, None]] = {}
    for name, value in _stated_values(experiment, with_sweep):
        values.setdefault(name, {})[value] = None
    with shown_in(experiment.units):
        sentences = [
            sentence
            for name in values
            for sentence in _sentences(name, values[name], experiment.units.get(name))
        ]
    sentences += _friction_sentences(*(max(values[f"friction.{part}"]) for part in ("breakaway", "coulomb")))
    longest = max(value for value in values["record.duration"] if isinstance(value, float))
    for file in values["input.file"]:
        sentences += _file_sentences(file, longest) if isinstance(file, str) else ()
    return sentences


def _stated_values(experiment: ExperimentConfig, with_sweep: bool) -> Iterator[tuple[str, Any]]:
    blocks = [experiment.ensemble, experiment.sweep] if with_sweep else []
    varied = {name for block in blocks for name in block.names}
    for name in parameter_names():
        if name not in varied:
            yield name, experiment.value(name)
    yield from experiment.baseline.items()
    for block in blocks:
        yield from block_values(block)


def block_values(block: SweepConfig) -> Iterator[tuple[str, Any]]:
    """The parameters that vary in a block, each with every value or end of its distribution."""
    for axes in (block.grid, block.zip):
        for name, values in axes.items():
            yield from ((name, value) for value in values)
    for name, distribution in (block.sample.over if block.sample else {}).items():
        yield from ((name, value) for value in argument_values(distribution))
    for part in block.union:
        yield from block_values(part)


def _sentences(name: str, stated: Iterable[Any], unit: str | None = None) -> Iterator[str]:
    """What is strange about the values of a parameter, some of which are written in a unit."""
    quantity = parameter_quantity(name)
    if quantity is None or quantity.usual is None:
        return
    low, high = (parse_quantity(bound, quantity.unit) for bound in quantity.usual)
    values = [value for value in stated if isinstance(value, float) and value != 0.0]
    below = sorted((value for value in values if abs(value) < low), key=abs)
    above = sorted((value for value in values if abs(value) > high), key=abs, reverse=True)
    for side, found in (("below", below), ("above", above)):
        if found:
            number = found[0] / parse_quantity(f"1 {unit}", quantity.unit) if unit else 0.0
            has_unit = _is_usual_number(number)
            may_group = has_unit and abs(number) >= 1.0 and low <= abs(found[0]) * 1000.0 <= high
            hint = "; is the point in it a thousands separator? Leave it out" if may_group else ""
            yield _sentence(name, quantity, side, found, has_unit=has_unit) + hint


def _is_usual_number(number: float) -> bool:
    """Whether people write a number of this size before a unit, so that it hardly is a number in SI."""
    return 0.01 <= abs(number) < 1e6


def _sentence(name: str, quantity: SI, side: str, found: list[float], *, has_unit: bool) -> str:
    others = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
    value, reason = f"{found[0]:g}", ""
    if has_unit:
        value = shown_value(name, found[0])
    elif quantity.unit != "1":
        value = f"{value} {quantity.unit.replace('*', '·')}"
        reason = "; a number without a unit is in SI"
    low, high = (bound.replace("*", "·") for bound in quantity.usual or ())
    place = side if found[0] > 0.0 else {"above": "beyond", "below": "short of"}[side]
    return f"{name} = {value}{others} is far {place} the usual {low} … {high}{reason}"


def _friction_sentences(breakaway: float, coulomb: float) -> Iterator[str]:
    """What is strange about the largest breakaway friction and the largest Coulomb friction [N]."""
    if breakaway < coulomb:
        less, more = shown_value("friction.breakaway", breakaway), shown_value("friction.coulomb", coulomb)
        yield (
            f"friction.breakaway = {less} is less than friction.coulomb = {more}:"
            " usually it is the larger of the two"
        )


def _file_sentences(text: str, duration: float) -> Iterator[str]:
    """What is strange about the rows of a file, for the longest record."""
    file, rows = text.partition("\n")[0].removeprefix("# "), parse_rows(text)
    n_late = int((rows.times > duration).sum())
    if n_late:
        yield (
            f"input.file = {file}: {n_late} of {counted(len(rows.times), 'row')} lie beyond"
            f" record.duration = {duration:g} s, the last at {rows.times[-1]:g} s"
        )
    amplitude = "input.amplitude" if rows.quantity == "voltage" else "control.amplitude"
    largest = float(abs(rows.values).max())
    for sentence in _sentences(amplitude, [largest]):
        yield f"input.file = {file}: the largest {rows.quantity}{sentence.removeprefix(amplitude)}"


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
        if name in stated and (sentence := _idle_sentence(name, needs, experiment))
    ]


def idle_draws(experiment: ExperimentConfig, names: Iterable[str]) -> set[str]:
    """Those of some parameters that have no effect in any run of a study, whatever they are."""
    needs = _NEEDS | ({} if _has_chance(experiment) else {"measurement.seed": ()})
    return {
        name
        for name in names
        if name in needs and (not needs[name] or _idle_sentence(name, needs[name], experiment))
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


def _idle_sentence(name: str, needs: tuple[_Needs, ...], experiment: ExperimentConfig) -> str:
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
