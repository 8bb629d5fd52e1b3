"""Values far from those of usual actuators, most often a missing unit; and parameters without an effect."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import Any, NamedTuple

from hydrofdi.config.drive import ControlConfig, parse_rows
from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.observation import TemperatureSensorConfig
from hydrofdi.config.request import SENSING, RunRequest, parameter_names, parameter_quantity
from hydrofdi.config.study import study_values
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.config.values import argument_values
from hydrofdi.physics.friction import LIMITED_PARAMETERS, laws_that_use
from hydrofdi.settings.messages import counted, typeset


def _values(
    experiment: ExperimentConfig, *, with_sweep: bool = True, with_study: bool = False
) -> dict[str, dict[Any, None]]:
    """Dotted parameter → its values, or ends of its distributions, in the runs of an experiment."""
    blocks = [experiment.ensemble, experiment.sweep] if with_sweep else []
    varied = {name for block in blocks for name in block.names_throughout}
    study = experiment.study if with_study else None
    values: dict[str, dict[Any, None]] = {}
    for name, value in chain(
        ((name, experiment.value(name)) for name in parameter_names() if name not in varied),
        experiment.baseline.items(),
        *map(_block_values, blocks),
        study_values(study) if study else (),
    ):
        values.setdefault(name, {})[value] = None
    return values


def _block_values(block: SweepConfig) -> Iterator[tuple[str, Any]]:
    return ((name, value) for name, stated in block.axes() for value in argument_values(stated))


class Unusual(NamedTuple):
    """Values of a parameter that are far from the `usual` ones [in `unit`], the farthest first."""

    name: str
    side: str
    values: Sequence[float]
    unit: str
    usual: tuple[float, float]

    @property
    def sentence(self) -> str:
        """What is strange."""
        others = f" (and {len(self.values) - 1} more)" if len(self.values) > 1 else ""
        usual = " … ".join(map(typeset, getattr(parameter_quantity(self.name), "usual", ())))
        shown = f"{self.values[0]:g} {typeset(self.unit)}".removesuffix(" 1")
        return f"{self.name} = {shown}{others} is far {self.side} the usual {usual}"


def unusual_parameters(experiment: ExperimentConfig, *, with_sweep: bool = True) -> list[Unusual]:
    """The parameters of which some value is far from the usual ones."""
    values = _values(experiment, with_sweep=with_sweep)
    return [unusual for name in values for unusual in _unusual(name, values[name])]


def unusual_values(experiment: ExperimentConfig, *, with_sweep: bool = True) -> list[str]:
    """A sentence on each parameter of which some value is far from the usual ones."""
    values = _values(experiment, with_sweep=with_sweep)
    sentences = [unusual.sentence for unusual in unusual_parameters(experiment, with_sweep=with_sweep)]
    breakaway, coulomb = (max(values[f"friction.{part}"]) for part in ("breakaway", "coulomb"))
    if breakaway < coulomb:
        sentences.append(
            f"friction.breakaway = {breakaway:g} N is less than friction.coulomb = {coulomb:g} N"
        )
    longest = max(value for value in values["record.duration"] if isinstance(value, float))
    for text in values["input.file"]:
        sentences += _file_sentences(text, longest) if isinstance(text, str) else ()
    return sentences


def _unusual(name: str, stated: Iterable[Any]) -> Iterator[Unusual]:
    """What is strange about the values of a parameter."""
    quantity = parameter_quantity(name)
    values = sorted((value for value in stated if isinstance(value, float) and value), key=abs)
    if quantity is None or not values:
        return
    low, high = usual = quantity.usual_range
    for side, far in (
        ("below", [value for value in values if abs(value) < low]),
        ("above", [value for value in values[::-1] if abs(value) > high]),
    ):
        if far:
            yield Unusual(name, side, far, quantity.unit, usual)


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
    for unusual in _unusual(amplitude, [float(abs(rows.values).max())]):
        yield f"input.file = {file}: the largest {rows.quantity}{unusual.sentence.removeprefix(amplitude)}"


SENSORS = [name for name in SENSING if name != "measurement"]

Rule = tuple[str, Callable[[Any], bool], Sequence[str]]
"""Option, whether a value of it lets the parameters have an effect, and the parameters."""


def _is(*values: Any) -> Callable[[Any], bool]:
    return values.__contains__


RULES: tuple[Rule, ...] = (
    ("actuator.end_stops", _is("elastic"), ("actuator.end_stop_position", "actuator.end_stop_stiffness")),
    ("actuator.stroke", lambda stroke: stroke is None, ("actuator.end_stop_position",)),
    (
        "actuator.hose_volume",
        bool,
        [f"actuator.hose_{name}" for name in ("modulus", "resistance", "inertance")]
        + ["measurement.pressures_at"],
    ),
    ("actuator.foundation_stiffness", bool, ("actuator.foundation_damping",)),
    ("supply.ripple", bool, ("supply.ripple_frequency",)),
    ("supply.return_resistance", bool, ("supply.return_time_constant",)),
    ("supply.droop", _is("first_order"), ("supply.droop_resistance", "supply.droop_time_constant")),
    (
        "fluid.law",
        _is("free_air"),
        ("fluid.free_air", "fluid.polytropic_exponent", "fluid.atmospheric_pressure"),
    ),
    (
        "fluid.temperature",
        bool,
        [f"temperature_sensor.{name}" for name in TemperatureSensorConfig.model_fields],
    ),
    ("friction.position_share", bool, ("friction.position_period",)),
    ("leakage.scored_width", bool, ("leakage.scored_centre",)),
    ("leakage.law", _is("laminar"), ("leakage.laminar_reference",)),
    ("leakage.law", _is("blended"), ("leakage.blending_pressure",)),
    ("leakage.onset", _is("step", "ramp"), ("leakage.onset_time",)),
    ("leakage.onset", _is("ramp"), ("leakage.onset_duration",)),
    ("control.law", _is("open"), ("input.amplitude",)),
    (
        "control.law",
        _is("p", "pi", "pid"),
        [f"control.{name}" for name in ControlConfig.model_fields if name != "law"],
    ),
    ("control.law", _is("pi", "pid"), ("control.integral_gain",)),
    ("control.law", _is("pid"), ("control.derivative_gain",)),
    ("input.shape", _is("square", "steps", "sine"), ("input.amplitude", "input.period", "control.amplitude")),
    ("input.shape", _is("steps"), ("input.seed",)),
    ("measurement.anti_alias", bool, ("measurement.anti_alias_order",)),
    ("load.random_force", bool, ("load.random_period", "load.random_change", "load.seed")),
    *(("friction.law", _is(*laws_that_use(name)), (f"friction.{name}",)) for name in LIMITED_PARAMETERS),
    *((f"{name}.order", _is("second"), (f"{name}.damping_ratio",)) for name in SENSORS),
    *((f"{name}.noise", bool, (f"{name}.noise_bandwidth",)) for name in SENSORS),
    *((f"{name}.hum", bool, (f"{name}.hum_frequency",)) for name in SENSORS),
)
"""All of a parameter's rules have to be met for an effect; parameters without one always have an effect."""


def idle_parameters(experiment: ExperimentConfig) -> list[str]:
    """A sentence on each parameter that is stated, or varies, but has no effect in any run."""
    default = RunRequest()
    stated = [
        name
        for name, values in _values(experiment).items()
        if any(value != default.value(name) for value in values)
    ]
    sentences: dict[str, str] = {}
    occurring = _values(experiment, with_study=True)
    for option, is_met, parameters in RULES:
        if not any(map(is_met, occurring[option])):
            choices = " or ".join("null" if value is None else f"{value}" for value in occurring[option])
            for name in set(parameters).intersection(stated) - sentences.keys():
                sentences[name] = f"{name} has no effect: {option} is {choices} in every run"
    return [sentences[name] for name in parameter_names() if name in sentences]
