"""Values far from those of usual actuators, most often a missing unit; parameters without an effect; and
studies that cannot show what they are asked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.drive import ControlConfig, parse_rows
from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.observation import TemperatureSensorConfig
from hydrofdi.config.request import SENSING, RunRequest, parameter_names, parameter_quantity
from hydrofdi.config.study import StudyConfig, study_values
from hydrofdi.config.values import argument_values
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import time_needed
from hydrofdi.indicators.contract import RecursiveIndicator
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
        ((n, value) for block in blocks for n, stated in block.axes() for value in argument_values(stated)),
        study_values(study) if study else (),
    ):
        values.setdefault(name, {})[value] = None
    return values


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


def study_mistakes(experiment: ExperimentConfig) -> list[str]:
    """What hinders a study of detection from showing what it is asked; nothing of another experiment."""
    if (study := experiment.study) is None:
        return []
    rules = _too_few_records, _free_supply_sensors, _onsets
    return [sentence for rule in rules for sentence in rule(experiment, study)]


def _free_supply_sensors(experiment: ExperimentConfig, study: StudyConfig) -> Iterator[str]:
    """A sentence on indicators that read the simulated supply pressure because nobody says otherwise."""
    made = experiment.indicator_choice.made(experiment.wavelet)
    labels = [label for label, own in made.items() if getattr(own.options, "supply", "") == "auto"]
    if labels and experiment.supply_sensor.is_default and not experiment.detection.sensors:
        yield (
            f"{', '.join(labels)}: 'supply: auto' reads the simulated supply pressure, without noise, as no"
            " supply_sensor is set; write 'supply: sum' or 'nominal' if your machine has no such sensor"
        )


def _too_few_records(experiment: ExperimentConfig, study: StudyConfig) -> Iterator[str]:
    """A sentence on each number of records that is too small for what it shall show."""
    rules, judged = experiment.detection, experiment.detection.indicators
    of_both = [
        f"{label}.{output.name}"
        for label, indicator in experiment.indicator_choice.made(experiment.wavelet).items()
        if not judged or label in judged
        for output in indicator.outputs
        if output.is_score and output.direction in (None, Direction.BOTH)
    ]
    one, both = (rules.records_for_threshold(direction) for direction in (Direction.RISING, Direction.BOTH))
    alarms = f"{100.0 * rules.false_alarm_rate:g} %"
    rule, rate = f"for {alarms} false alarms, {rules.threshold}", "shows no rate of false alarms"
    detection = f"is too few for one level to show {100.0 * rules.probability:g} % detection: that"
    on_both = f"sets no threshold for scores that may alarm on both sides, such as {''.join(of_both[:1])}"
    n_shift = study.healthy.shift if study.shifts else None
    n_each = study.faults.each if study.faults else None
    for key, count, needed, cannot in (
        ("healthy.fit", study.healthy.fit, one, f"sets no threshold: {rule}"),
        ("healthy.fit", study.healthy.fit, both if of_both and both > one else 0, f"{on_both}: {rule}"),
        ("healthy.test", study.healthy.test, rules.records_for_false_alarms, f"{rate}: {alarms}"),
        ("healthy.shift", n_shift, rules.records_for_false_alarms, f"{rate}: {alarms}"),
        ("faults.each", n_each, rules.records_for_detection, detection),
        *_charted_records(experiment, study),
    ):
        if count is not None and count < needed:
            yield f"study.{key} = {count} {cannot} needs {needed:,} records"


def _watched(experiment: ExperimentConfig) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Indicators that charts watch, each with the instants of its trace [s]."""
    online, made = experiment.detection.online, experiment.indicator_choice.made(experiment.wavelet)
    charts = online.charts.values() if online else ()
    for label in dict.fromkeys(chart.of.partition(".")[0] for chart in charts):
        indicator = made[label]
        assert isinstance(indicator, RecursiveIndicator)
        run = experiment.nominal_parameters
        yield label, indicator.watched_instants(run.record.sampling_frequency, run.n_discarded)


def _charted_records(experiment: ExperimentConfig, study: StudyConfig) -> Iterator[tuple[str, int, int, str]]:
    """Healthy records that charts need: key, number, how many are needed, and what for."""
    online = experiment.detection.online
    for label, instants in _watched(experiment):
        if online is not None and instants.size > 1:
            duration, every = float(instants[1] - instants[0]) * instants.size, max(online.false_alarm_every)
            proof = time_needed(every, experiment.detection.confidence)
            fit, test = (math.ceil(time / duration - 1e-9) for time in (every, proof))
            between = f"{every / 3600.0:g} h between false alarms: {label}"
            yield "healthy.fit", study.healthy.fit, fit, f"sets no limit for {between}"
            yield "healthy.test", study.healthy.test, test, f"does not show that a limit holds for {between}"


def _onsets(experiment: ExperimentConfig, study: StudyConfig) -> Iterator[str]:
    """A sentence on leaks that do not set in while charts watch them."""
    leakage = experiment.leakage
    traces = [(trace[0], trace[-1]) for _, trace in _watched(experiment) if trace.size > 1]
    if study.faults is None or not traces or "leakage.onset" in experiment.varied_names:
        return
    first, last = max(start for start, _ in traces), min(end for _, end in traces)
    if leakage.onset == "constant" or not first < leakage.onset_time < last:
        yield (
            f"leakage.onset = {leakage.onset}, leakage.onset_time = {leakage.onset_time:g} s: no delay is"
            f" stated unless leaks set in between {first:g} s and {last:g} s, where charts watch"
        )
    elif study.faults.parameter == "leakage.internal_flow" and (
        experiment.baseline.get("leakage.onset") != "constant"
    ):
        yield (
            f"leakage.onset = {leakage.onset}: levels of faults are means over whole records;"
            " baseline: {leakage.onset: constant} makes them the flow after the onset"
        )
